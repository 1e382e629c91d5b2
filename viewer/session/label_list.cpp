// viewer/session/label_list.cpp: see label_list.h.
#include "viewer/session/label_list.h"

#include "bricking/labels/label_names.h"
#include "core/base/error.h"

#include <algorithm>
#include <map>
#include <utility>

namespace tessera {
namespace {

Label labelOf(const ListedLabel& listed) {
    return {listed.value, listed.name, listed.group};
}

std::vector<Label> labelsOf(const LabelList& list) {
    std::vector<Label> labels;
    labels.reserve(list.size());
    for (const ListedLabel& listed : list)
        labels.push_back(labelOf(listed));
    return labels;
}

std::vector<bool> shownOf(const std::vector<Label>& all, const Labels& labels) {
    const LabelMatcher matcher(all);
    std::vector<bool> shown(all.size(), labels.show.empty());
    for (const std::string& pattern : labels.show)
        matcher.forEach(pattern, [&](std::size_t n) { shown[n] = true; });
    for (const std::string& pattern : labels.hide)
        matcher.forEach(pattern, [&](std::size_t n) { shown[n] = false; });
    return shown;
}

/// Patterns that mean one label and no other: its value, behind zeros where another has that for a name.
class Patterns {
  public:
    explicit Patterns(const LabelList& list) {
        for (const ListedLabel& label : list)
            if (label.name.find_first_not_of("0123456789") == std::string::npos)
                named_.emplace(label.name, label.value);
    }
    std::string of(const ListedLabel& label) const {
        std::string pattern = std::to_string(label.value);
        const auto isOther = [&] {
            const auto [from, to] = named_.equal_range(pattern);
            return std::any_of(from, to, [&](const auto& name) { return name.second != label.value; });
        };
        while (isOther())
            pattern.insert(0, 1, '0');
        return pattern;
    }

  private:
    std::multimap<std::string, std::uint32_t> named_; // names that are whole numbers, and their values
};

void checkCount(std::size_t count) {
    if (count > Labels::kMostPatterns)
        throw InputError("no more than " + std::to_string(Labels::kMostPatterns) +
                         " labels can be chosen one by one, but this needs " + std::to_string(count));
}

/// Names the labels that show, where the scene does, else those that are fewer: shown or not.
void nameShown(const LabelList& list, const std::vector<bool>& shown, Labels& labels) {
    const bool unlabelled = showsUnlabelled(labels);
    const auto count = static_cast<std::size_t>(std::count(shown.begin(), shown.end(), true)),
               hidden = list.size() - count;
    const bool stays = !labels.show.empty() && count <= Labels::kMostPatterns;
    const bool namesShown = count > 0 && hidden > 0 && (stays || count < hidden);
    labels.show.clear();
    labels.hide.clear();
    checkCount(namesShown ? count : hidden);
    const Patterns patterns(list);
    for (std::size_t n = 0; n < list.size(); ++n)
        if (shown[n] == namesShown)
            (namesShown ? labels.show : labels.hide).push_back(patterns.of(list[n]));
    if (showsUnlabelled(labels) != unlabelled)
        labels.unlabelled = unlabelled;
}

/// Sets a part of the look of labels: in the last rule of a label alone, if no later rule has that part, else
/// in a new one.
template <typename Part>
Labels withPart(const LabelList& list, Labels labels, LabelNumbers numbers,
                std::optional<Part> LabelRule::*part, const Part& value) {
    const Patterns patterns(list);
    for (const std::size_t number : numbers) {
        const Label label = labelOf(list[number]);
        const std::string own = patterns.of(list[number]);
        const auto later = std::find_if(labels.each.rbegin(), labels.each.rend(), [&](const LabelRule& rule) {
            return rule.of == own || (rule.*part && labelMatches(label, rule.of));
        });
        if (later != labels.each.rend() && later->of == own)
            (*later).*part = value;
        else
            ((labels.each.emplace_back(LabelRule{own})).*part) = value;
    }
    checkCount(labels.each.size());
    return labels;
}

void dropEmptyRules(Labels& labels) {
    std::erase_if(labels.each, [](const LabelRule& rule) {
        return !rule.look && !rule.opacity && !rule.colour && !rule.fill && !rule.outline &&
               !rule.hasOptics();
    });
}

} // namespace

std::vector<LabelState> labelStates(const LabelList& list, const Labels& labels) {
    const std::vector<Label> all = labelsOf(list);
    const std::vector<bool> shown = shownOf(all, labels);
    const LabelMatcher matcher(all);
    std::vector<LabelState> states(list.size());
    for (std::size_t n = 0; n < list.size(); ++n)
        states[n] = {shown[n], labels.look, labels.opacity, glm::dvec3(list[n].colour)};
    for (const LabelRule& rule : labels.each)
        matcher.forEach(rule.of, [&](std::size_t n) {
            states[n].look = rule.lookAfter(states[n].look);
            if (rule.opacity)
                states[n].opacity = rule.opacity;
            states[n].colour = rule.colour.value_or(states[n].colour);
        });
    return states;
}

std::vector<LegendLabel> legendLabels(const LabelList& list, const Labels& labels) {
    std::vector<LegendLabel> shown;
    const std::vector<LabelState> states = labelStates(list, labels);
    for (std::size_t n = 0; n < list.size(); ++n)
        if (states[n].shows && list[n].hasVoxels)
            shown.push_back({list[n].name.empty() ? "label " + std::to_string(list[n].value) : list[n].name,
                             glm::vec3(states[n].colour)});
    return shown;
}

bool showsUnlabelled(const Labels& labels) {
    return labels.unlabelled.value_or(labels.show.empty());
}

std::optional<std::size_t> numberOf(const LabelList& list, std::uint32_t value) {
    const auto at = std::lower_bound(list.begin(), list.end(), value,
                                     [](const ListedLabel& a, std::uint32_t v) { return a.value < v; });
    if (at == list.end() || at->value != value)
        return std::nullopt;
    return static_cast<std::size_t>(at - list.begin());
}

Labels withShown(const LabelList& list, const Labels& labels, LabelNumbers numbers, bool shows) {
    std::vector<bool> shown = shownOf(labelsOf(list), labels);
    for (const std::size_t number : numbers)
        shown[number] = shows;
    Labels changed = labels;
    nameShown(list, shown, changed);
    return changed;
}

Labels withAlone(const LabelList& list, const Labels& labels, LabelNumbers numbers) {
    checkCount(numbers.size());
    const Patterns patterns(list);
    Labels changed = labels;
    changed.show.clear();
    changed.hide.clear();
    for (const std::size_t number : numbers)
        changed.show.push_back(patterns.of(list[number]));
    if (changed.unlabelled.value_or(false))
        changed.unlabelled.reset(); // off while labels are named
    return changed;
}

Labels withAllShown(const Labels& labels) {
    Labels changed = labels;
    changed.show.clear();
    changed.hide.clear();
    return changed;
}

Labels withUnlabelled(const Labels& labels, bool shows) {
    Labels changed = labels;
    changed.unlabelled = shows;
    return changed;
}

Labels withLook(const Labels& labels, LabelLook look) {
    Labels changed = labels;
    changed.look = look;
    for (LabelRule& rule : changed.each)
        rule.look.reset();
    dropEmptyRules(changed);
    return changed;
}

Labels withColour(const LabelList& list, const Labels& labels, LabelNumbers numbers,
                  const glm::dvec3& colour) {
    return withPart(list, labels, numbers, &LabelRule::colour, colour);
}

Labels withOpacity(const LabelList& list, const Labels& labels, LabelNumbers numbers, double opacity) {
    return withPart(list, labels, numbers, &LabelRule::opacity, opacity);
}

Labels withoutRules(const LabelList& list, const Labels& labels, LabelNumbers numbers) {
    const Patterns patterns(list);
    Labels changed = labels;
    for (const std::size_t number : numbers) {
        const std::string own = patterns.of(list[number]);
        std::erase_if(changed.each, [&](const LabelRule& rule) { return rule.of == own; });
    }
    return changed;
}

} // namespace tessera
