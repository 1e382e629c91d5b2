// render/labels/label_looks.cpp: see label_looks.h.
#include "render/labels/label_looks.h"

#include "bricking/labels/label_names.h"
#include "core/base/error.h"
#include "core/base/names.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

namespace tessera {
namespace {

/// The look of one label.
struct OneLook {
    bool shows = true;
    LabelLook look = LabelLook::solid;
    double opacity = 1;    // a factor on the function's extinction
    double extinction = 0; // solid: per mm
    glm::vec3 colour{1};
    std::size_t optics = 0;                   // opticsOf()
    double fill = Labels::kFill, outline = 0; // in slices: opacity, pixels
};

double extinctionPerMm(double opacity) {
    return -std::log1p(-std::min(opacity, 1 - std::ldexp(1.0, -24)));
}

/// Calls visit(number) for every label that matches.
template <typename Visit>
void forEachMatch(const LabelTable& table, const LabelMatcher& matcher, const std::string& pattern,
                  const std::string& where, const Visit& visit) {
    if (!matcher.forEach(pattern, visit))
        throw badFile(where, "the name, the value or the group of a label",
                      "\"" + pattern + "\"; nearest: " + joinNames(nearestNames(table, pattern)));
}

std::vector<OneLook> looksOf(const LabelTable& table, const Labels& labels, double voxelMm,
                             const std::string& where) {
    const LabelMatcher matcher(table.labels);
    std::vector<OneLook> looks(table.labels.size());
    std::vector<std::optional<double>> opacity(looks.size(), labels.opacity), fill(looks.size(), labels.fill);
    for (std::size_t n = 0; n < looks.size(); ++n) {
        looks[n].shows = labels.show.empty();
        looks[n].look = labels.look;
        looks[n].outline = labels.outline;
        const Label& label = table.labels[n];
        looks[n].colour = label.colour ? *label.colour : labelColour(label.value);
    }
    for (const std::string& pattern : labels.show)
        forEachMatch(table, matcher, pattern, where + ".show", [&](std::size_t n) { looks[n].shows = true; });
    for (const std::string& pattern : labels.hide)
        forEachMatch(table, matcher, pattern, where + ".hide",
                     [&](std::size_t n) { looks[n].shows = false; });
    for (std::size_t number = 0; number < labels.each.size(); ++number) {
        const LabelRule& rule = labels.each[number];
        const std::size_t optics = opticsOf(labels, number);
        forEachMatch(table, matcher, rule.of, where + ".each", [&](std::size_t n) {
            looks[n].look = rule.lookAfter(looks[n].look);
            if (optics > 0)
                looks[n].optics = optics;
            if (rule.opacity)
                opacity[n] = rule.opacity;
            if (rule.colour)
                looks[n].colour = glm::vec3(*rule.colour);
            if (rule.fill)
                fill[n] = rule.fill;
            looks[n].outline = rule.outline.value_or(looks[n].outline);
        });
    }
    for (std::size_t n = 0; n < looks.size(); ++n) {
        looks[n].opacity = opacity[n].value_or(1.0);
        looks[n].fill = fill[n].value_or(opacity[n].value_or(Labels::kFill));
        looks[n].extinction =
            opacity[n] ? extinctionPerMm(*opacity[n]) : extinctionPerMm(Labels::kSolidOpacity) / voxelMm;
    }
    return looks;
}

} // namespace

LabelTable namedLabels(const LabelTable& table, const Labels& labels) {
    LabelTable named = table;
    if (labels.names == Labels::kTotalSegmentator)
        applyNames(named, totalSegmentatorNames());
    else if (!labels.names.empty())
        applyNames(named, readLabelNames(labels.names));
    applyKnownNames(named);
    return named;
}

LabelMedium labelLooks(const LabelTable& table, const Labels& labels, double voxelMm,
                       const std::string& where) {
    const std::vector<OneLook> looks = looksOf(table, labels, voxelMm, where);
    const auto isOf = [&](const OneLook& look) { return look.optics == labels.optics.value_or(look.optics); };
    const bool showsUnlabelled =
        labels.optics.value_or(0) == 0 && labels.unlabelled.value_or(labels.show.empty());
    double density = 0;
    for (const OneLook& look : looks)
        if (look.shows && look.look == LabelLook::solid && isOf(look))
            density = std::max(density, look.extinction);
    LabelMedium medium;
    medium.density = static_cast<float>(density);
    for (const std::vector<std::uint16_t>& set : table.sets) {
        LabelFactors f;
        f.plain = set.empty() && showsUnlabelled ? 1.0f : 0.0f;
        glm::dvec3 colour(0);
        double shown = 0, coloured = 0, plain = 0, tinted = 0, solid = 0;
        for (const std::uint16_t number : set) {
            const OneLook& look = looks[number];
            if (!look.shows)
                continue;
            ++shown;
            if (!isOf(look))
                continue; // drawn as another volume
            double share = 0;
            if (look.look == LabelLook::plain)
                plain += look.opacity;
            else if (look.look == LabelLook::tint)
                tinted += share = look.opacity;
            else
                solid += share = density > 0 ? look.extinction / density : 0;
            colour += share * glm::dvec3(look.colour);
            coloured += share;
        }
        if (shown > 0) {
            f.plain = static_cast<float>(plain / shown);
            f.tinted = static_cast<float>(tinted / shown);
            f.solid = static_cast<float>(solid / shown);
        }
        if (coloured > 0)
            f.colour = glm::vec3(colour / coloured);
        medium.bySet.push_back(f);
    }
    return medium;
}

namespace {

/// What the fill of labels that lie at one place keeps of a colour and adds to it: the mean of what each
/// does.
void setFill(const std::vector<OneLook>& looks, SliceLooks::Set& set) {
    glm::dvec3 keep(0), add(0);
    double cover = 0;
    for (const std::uint16_t number : set.labels) {
        const OneLook& look = looks[number];
        const glm::dvec3 filled = look.fill * glm::dvec3(look.colour);
        keep += look.look == LabelLook::plain ? 1.0 : 1 - look.fill;
        if (look.look == LabelLook::solid) {
            add += filled;
            cover += look.fill;
        }
        if (look.look == LabelLook::tint)
            keep += filled;
    }
    const auto count = static_cast<double>(set.labels.size());
    set.keep = glm::vec3(keep / count);
    set.add = glm::vec3(add / count);
    set.cover = static_cast<float>(cover / count);
}

} // namespace

SliceLooks sliceLooks(const LabelTable& table, const Labels& labels, const std::string& where) {
    const std::vector<OneLook> looks = looksOf(table, labels, 1, where);
    SliceLooks slice;
    for (const OneLook& look : looks) {
        slice.labels.push_back({look.colour, static_cast<float>(look.outline)});
        slice.widest = std::max(slice.widest, look.shows ? look.outline : 0);
    }
    const auto comesFirst = [](const auto& a, const auto& b) { return comesBefore(a, b); };
    std::map<std::vector<std::uint16_t>, std::uint16_t, decltype(comesFirst)> numbers(comesFirst);
    std::vector<std::vector<std::uint16_t>> shown(table.sets.size());
    numbers[{}] = 0;
    for (std::size_t n = 0; n < table.sets.size(); ++n) {
        std::copy_if(table.sets[n].begin(), table.sets[n].end(), std::back_inserter(shown[n]),
                     [&](std::uint16_t number) { return looks[number].shows; });
        numbers[shown[n]] = 0;
    }
    for (auto& [set, number] : numbers) {
        number = static_cast<std::uint16_t>(slice.sets.size());
        slice.sets.push_back({set});
        if (!set.empty())
            setFill(looks, slice.sets.back());
    }
    for (const auto& set : shown)
        slice.ofSet.push_back(numbers[set]);
    return slice;
}

} // namespace tessera
