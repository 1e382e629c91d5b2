// viewer/session/label_list.h: the labels beside an open volume as a list, how they show under a scene, and
// edits of that. Edits name labels by their values, so they mean no others.
#pragma once

#include "core/scene/labels.h"
#include "viewer/annotations/figure.h" // LegendLabel

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

struct ListedLabel {
    std::uint32_t value = 0;
    std::string name, group; // group: "" none
    glm::vec3 colour{1};     // linear light: of a label to which the scene gives none
    bool hasVoxels = true;   // on the scan
    bool operator==(const ListedLabel&) const = default;
};

/// By ascending value, no value twice.
using LabelList = std::vector<ListedLabel>;
/// Numbers of labels in the list.
using LabelNumbers = std::span<const std::size_t>;

/// A label under a scene.
struct LabelState {
    bool shows = true;
    LabelLook look = LabelLook::solid;
    std::optional<double> opacity = {}; // as Labels::opacity
    glm::dvec3 colour{1};               // linear light
    bool operator==(const LabelState&) const = default;
};

/// Of every label of the list. Patterns that match no label have no effect.
std::vector<LabelState> labelStates(const LabelList& list, const Labels& labels);
/// Labels that show and have voxels, as a legend has them.
std::vector<LegendLabel> legendLabels(const LabelList& list, const Labels& labels);
/// True if tissue without a label shows.
bool showsUnlabelled(const Labels& labels);
/// The number of a label; none if the list has no such value.
std::optional<std::size_t> numberOf(const LabelList& list, std::uint32_t value);

// Edits. They throw InputError where more than Labels::kMostPatterns labels would have to be named.

/// Other labels, and tissue without a label, show or not as before.
Labels withShown(const LabelList& list, const Labels& labels, LabelNumbers numbers, bool shows);
/// These labels and nothing else. withAllShown() shows tissue without a label again, unless it was off.
Labels withAlone(const LabelList& list, const Labels& labels, LabelNumbers numbers);
Labels withAllShown(const Labels& labels);
Labels withUnlabelled(const Labels& labels, bool shows);
/// The look of all labels; rules for some lose theirs.
Labels withLook(const Labels& labels, LabelLook look);
/// @param colour  linear light
Labels withColour(const LabelList& list, const Labels& labels, LabelNumbers numbers,
                  const glm::dvec3& colour);
/// @param opacity  as Labels::opacity
Labels withOpacity(const LabelList& list, const Labels& labels, LabelNumbers numbers, double opacity);
/// Colour, opacity and look of these labels are those of the others again.
Labels withoutRules(const LabelList& list, const Labels& labels, LabelNumbers numbers);

} // namespace tessera
