// core/scene/labels.h: Labels: a segmentation beside a volume, and how a picture shows it (docs/sampling.md,
// "Labels").
#pragma once

#include "core/base/names.h"
#include "core/scene/transfer_function.h"

#include <cstddef>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// Labelled tissue: a medium of its own in the label's colour, whatever its values; as the transfer function
/// shows it, in the label's colour; or as the transfer function shows it.
enum class LabelLook { solid, tint, plain };
template <> const NameTable<LabelLook>& namesOf<LabelLook>();

/// Between voxels: where the shares of labels are equal; or the voxels' own faces.
enum class LabelBorders { smooth, nearest };
template <> const NameTable<LabelBorders>& namesOf<LabelBorders>();

/// The look of the labels that a pattern names; what it leaves out is that of the others.
struct LabelRule {
    std::string of; // a name with * and ?, a value, or "group:NAME"
    std::optional<LabelLook> look = {};
    std::optional<double> opacity = {};
    std::optional<glm::dvec3> colour = {}; // linear light
    /// In place of the volume's; its labels are plain where no look is named.
    std::optional<TransferChoice> transferFunction = {};
    std::optional<MaterialResponse> material = {}; // in place of the function's and the scene's
    std::optional<double> fill = {};               // in slices, as Labels::fill
    std::optional<double> outline = {};            // in slices, as Labels::outline
    bool operator==(const LabelRule&) const = default;
    /// True if its labels are not drawn with the volume's function and materials.
    bool hasOptics() const { return transferFunction || material; }
    /// The look of its labels, which was another before.
    LabelLook lookAfter(LabelLook before) const {
        return look.value_or(transferFunction ? LabelLook::plain : before);
    }
};

struct Labels {
    static constexpr std::size_t kMostPatterns = 4096;
    /// In place of a file of names: those that TotalSegmentator gives its values.
    static constexpr const char* kTotalSegmentator = "totalsegmentator";
    /// Opacity of a solid label that names none, over the edge of a voxel.
    static constexpr double kSolidOpacity = 0.999;
    /// In slices: opacity of the fill of a label that names none; the widest outline, pixels.
    static constexpr double kFill = 0.5, kWidestOutline = 16;

    std::filesystem::path path;  // a file or folder; "" none
    std::filesystem::path names; // of a file with names and colours; ""  the labels' own
    LabelLook look = LabelLook::solid;
    /// [0,1]. solid: per mm, by default kSolidOpacity over a voxel; else a factor on the function's
    /// extinction, 1.
    std::optional<double> opacity = {};
    /// In slices: opacity of the fill; none: `opacity`, else kFill. Width of outlines, pixels; 0: none.
    std::optional<double> fill = {};
    double outline = 1;
    LabelBorders borders = LabelBorders::smooth;
    /// Patterns of the labels that show; none: all. Labels of `hide` do not.
    std::vector<std::string> show, hide;
    /// True if tissue without a label shows. None: it does unless `show` names labels.
    std::optional<bool> unlabelled = {};
    std::vector<LabelRule> each; // of several rules for a label the last one counts
    bool sameFrame = false;      // taken though the frames of reference differ
    /// Where they were imported to; not in files.
    std::filesystem::path store = {};
    /// Only labels of these optics (opticsOf()) show; 0: those without, and tissue without a label. None:
    /// all, as the volume's function shows them. Not in files.
    std::optional<std::size_t> optics = {};
    /// Number of their volume in the scene that names them, for messages; none: 0. Not in files.
    std::optional<std::size_t> ofVolume = {};
    /// "volumes[0].labels"
    std::string place() const { return "volumes[" + std::to_string(ofVolume.value_or(0)) + "].labels"; }
    bool operator==(const Labels&) const = default;
};

/// The function and material of a rule: the number, from 1, of the first rule that has the same; 0 where it
/// has none of its own.
/// @param rule  of labels.each
std::size_t opticsOf(const Labels& labels, std::size_t rule);

} // namespace tessera
