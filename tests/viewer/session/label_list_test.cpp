// tests/viewer/session/label_list_test.cpp: edits of labels against a list of what each label shows, for
// scenes with any patterns and rules; and the states of labels against those that pictures have.
#include "core/base/error.h"
#include "render/labels/label_looks.h"
#include "viewer/session/label_list.h"

#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

using Numbers = std::vector<std::size_t>;

/// Names that are numbers, also each other's values, and groups.
LabelList trickyLabels() {
    return {{1, "2", "even", glm::vec3(0.1f), true}, {2, "1", "", glm::vec3(0.2f), true},
            {3, "lung left", "lungs", {}, true},     {4, "lung right", "lungs", {}, false},
            {10, "010", "even", {}, true},           {12, "liver*", "", {}, true},
            {100, "group:lungs", "", {}, true},      {4294967295, "0004294967295", "", {}, true}};
}

class Random {
  public:
    explicit Random(unsigned seed) : random_(seed) {}
    std::size_t below(std::size_t end) { return random_() % end; }
    Numbers some(std::size_t of) {
        Numbers numbers;
        for (std::size_t n = 0; n < of; ++n)
            if (below(3) == 0)
                numbers.push_back(n);
        return numbers.empty() ? Numbers{below(of)} : numbers;
    }
    /// As a user may write them.
    Labels labels() {
        const std::vector<std::string> patterns = {"1",           "2",      "010", "lung*",
                                                   "group:lungs", "liver?", "*",   "12"};
        const auto list = [&] {
            std::vector<std::string> some;
            while (below(2) == 0)
                some.push_back(patterns[below(patterns.size())]);
            return some;
        };
        Labels labels;
        labels.path = "/labels.nrrd";
        labels.show = list();
        labels.hide = list();
        if (below(2) == 0)
            labels.unlabelled = below(2) == 0;
        for (const std::string& pattern : list()) {
            LabelRule rule{pattern};
            if (below(2) == 0)
                rule.colour = glm::dvec3(0.25 * static_cast<double>(below(4)));
            if (below(2) == 0)
                rule.opacity = 0.25 * static_cast<double>(below(4));
            if (below(3) == 0)
                rule.look = LabelLook::tint;
            labels.each.push_back(rule);
        }
        return labels;
    }

  private:
    std::mt19937 random_;
};

TEST(LabelEdits, ChangeWhatTheyAreFor) {
    const LabelList list = trickyLabels();
    Random random(3);
    for (int n = 0; n < 2000; ++n) {
        Labels labels = random.labels();
        for (int step = 0; step < 4; ++step) {
            std::vector<LabelState> states = labelStates(list, labels);
            bool unlabelled = showsUnlabelled(labels);
            const Numbers numbers = random.some(list.size());
            switch (random.below(7)) {
            case 0:
            case 1: {
                const bool shows = random.below(2) == 0;
                labels = withShown(list, labels, numbers, shows);
                for (const std::size_t number : numbers)
                    states[number].shows = shows;
                break;
            }
            case 2:
                labels = withAlone(list, labels, numbers);
                for (LabelState& state : states)
                    state.shows = false;
                for (const std::size_t number : numbers)
                    states[number].shows = true;
                unlabelled = false;
                break;
            case 3:
                labels = withColour(list, labels, numbers, {0.5, 0.6, 0.7});
                for (const std::size_t number : numbers)
                    states[number].colour = {0.5, 0.6, 0.7};
                break;
            case 4:
                labels = withOpacity(list, labels, numbers, 0.1);
                for (const std::size_t number : numbers)
                    states[number].opacity = 0.1;
                break;
            case 5:
                labels = withLook(labels, LabelLook::plain);
                for (LabelState& state : states)
                    state.look = LabelLook::plain;
                break;
            default:
                labels = withUnlabelled(labels, unlabelled = random.below(2) == 0);
            }
            ASSERT_EQ(labelStates(list, labels), states) << n;
            ASSERT_EQ(showsUnlabelled(labels), unlabelled) << n;
        }
        labels = withAllShown(labels);
        for (const LabelState& state : labelStates(list, labels))
            ASSERT_TRUE(state.shows);
    }
}

/// Tissue without a label is back where it was on before.
TEST(LabelEdits, AllShownIsTheEndOfAlone) {
    const LabelList list = trickyLabels();
    for (const std::optional<bool> unlabelled : {std::optional<bool>(), {false}, {true}}) {
        Labels labels;
        labels.unlabelled = unlabelled;
        const Labels after = withAllShown(withAlone(list, labels, Numbers{2}));
        EXPECT_EQ(showsUnlabelled(after), showsUnlabelled(labels));
        EXPECT_TRUE(after.show.empty() && after.hide.empty());
        const Labels two = withShown(list, withAlone(list, labels, Numbers{2}), Numbers{3}, true);
        EXPECT_EQ(showsUnlabelled(withAllShown(two)), showsUnlabelled(labels));
    }
}

TEST(LabelEdits, ARuleALabel) {
    const LabelList list = trickyLabels();
    Labels labels;
    for (int n = 0; n < 5; ++n)
        labels =
            withOpacity(list, withColour(list, labels, Numbers{5}, {0, 0, n / 8.0}), Numbers{5}, n / 8.0);
    ASSERT_EQ(labels.each.size(), 1u);
    EXPECT_EQ(labels.each[0].of, "12") << "a value, and not the name, which is a pattern";
    EXPECT_TRUE(withoutRules(list, labels, Numbers{5}).each.empty());
    EXPECT_EQ(withoutRules(list, labels, Numbers{0}), labels);
}

TEST(LabelEdits, MoreThanASceneCanNameAreRefused) {
    LabelList many;
    Numbers half;
    for (std::uint32_t n = 0; n < 2 * Labels::kMostPatterns + 2; ++n) {
        many.push_back({n + 1, "n", "", {}, true});
        if (n % 2 == 0)
            half.push_back(n);
    }
    EXPECT_THROW(withShown(many, {}, half, false), InputError);
    EXPECT_THROW(withAlone(many, {}, half), InputError);
    EXPECT_THROW(withOpacity(many, {}, half, 0.5), InputError);
    half.pop_back();
    EXPECT_EQ(withShown(many, {}, half, false).hide.size(), Labels::kMostPatterns);
}

TEST(LabelEdits, StatesAreThoseOfPictures) {
    const LabelList list = trickyLabels();
    LabelTable table;
    for (std::size_t n = 0; n < list.size(); ++n) {
        table.labels.push_back({list[n].value, list[n].name, list[n].group, list[n].colour});
        table.sets.push_back({static_cast<std::uint16_t>(n)});
    }
    Random random(8);
    for (int n = 0; n < 500; ++n) {
        const Labels labels = random.labels();
        const std::vector<LabelState> states = labelStates(list, labels);
        const LabelMedium medium = labelLooks(table, labels, 1, "labels");
        EXPECT_EQ(medium.bySet[0].shows(), showsUnlabelled(labels));
        for (std::size_t number = 0; number < list.size(); ++number) {
            const LabelFactors& factors = medium.bySet[number + 1];
            const LabelState& state = states[number];
            const bool shows = state.shows && state.opacity.value_or(1) > 0;
            ASSERT_EQ(factors.shows(), shows) << n << ", label " << number;
            if (!shows)
                continue;
            EXPECT_EQ(factors.solid > 0, state.look == LabelLook::solid);
            EXPECT_EQ(factors.tinted > 0, state.look == LabelLook::tint);
            EXPECT_EQ(factors.plain > 0, state.look == LabelLook::plain);
            if (state.look != LabelLook::plain) {
                EXPECT_NEAR(factors.colour.r, state.colour.r, 1e-6);
            }
            if (state.look == LabelLook::tint) {
                EXPECT_NEAR(factors.tinted, state.opacity.value_or(1), 1e-6);
            }
        }
    }
}

} // namespace
} // namespace tessera::test
