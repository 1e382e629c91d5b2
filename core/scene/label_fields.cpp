// core/scene/label_fields.cpp: the keys of labels: see scene_fields.h.
#include "core/base/error.h"
#include "core/scene/scene_fields.h"

#include <sstream>

namespace tessera {
namespace {

/// A list of patterns; typed "liver,kidney*".
Kind<std::vector<std::string>> patternsKind() {
    const Kind<std::vector<std::string>> list = listOf(anyText(), Labels::kMostPatterns, "patterns");
    return {[list](const JsonValue& value) {
                if (!value.isTyped() || !value.isText())
                    return list.read(value);
                std::vector<std::string> patterns;
                std::istringstream text(value.text());
                for (std::string one; std::getline(text, one, ',');)
                    if (!one.empty())
                        patterns.push_back(one);
                if (patterns.empty())
                    value.refuse("names of labels, separated by commas");
                return patterns;
            },
            list.write, list.schema};
}

const Fields<LabelRule>& ruleFields() {
    static const Fields<LabelRule> fields = [] {
        Fields<LabelRule> f("label");
        f.add("of", &LabelRule::of, anyText(), "A name with * and ?, a value, or group:NAME.").required();
        f.add("look", &LabelRule::look, named<LabelLook>(), "As labels.look.");
        f.add("opacity", &LabelRule::opacity, numberIn(0, 1), "As labels.opacity.");
        f.add("rgb", &LabelRule::colour, colourKind(), "Colour, linear light.");
        f.add("transferFunction", &LabelRule::transferFunction, transferKind(),
              "A function of their own: the name of a preset, or the points. Their look is plain where none "
              "is named.")
            .allowedBy([](const LabelRule& rule, const JsonValue& whole) {
                if (rule.look == LabelLook::solid)
                    throw badFile(whole.place(), "look plain or tint beside a transferFunction", "solid");
            });
        f.add("material", &LabelRule::material, objectOf(responseFields()),
              "What they make of light, in place of materials and shading.");
        f.add("fill", &LabelRule::fill, numberIn(0, 1), "As labels.fill.");
        f.add("outline", &LabelRule::outline, numberIn(0, Labels::kWidestOutline), "As labels.outline.");
        return f;
    }();
    return fields;
}

} // namespace

template <> const NameTable<LabelLook>& namesOf<LabelLook>() {
    static const NameTable<LabelLook> names{
        {{LabelLook::solid, "solid"}, {LabelLook::tint, "tint"}, {LabelLook::plain, "plain"}}};
    return names;
}

template <> const NameTable<LabelBorders>& namesOf<LabelBorders>() {
    static const NameTable<LabelBorders> names{
        {{LabelBorders::smooth, "smooth"}, {LabelBorders::nearest, "nearest"}}};
    return names;
}

const Fields<Labels>& labelsFields() {
    static const Fields<Labels> fields = [] {
        Fields<Labels> f("labels", "A segmentation beside the volume, and how it shows.");
        f.add("path", &Labels::path,
              anyText()
                  .checked([](const std::string& path, const JsonValue& value) {
                      if (path.empty())
                          value.refuse("the path of labels");
                  })
                  .described({{"minLength", 1}}),
              "Path of a label file, or of a folder with a mask for each structure, relative to the scene's "
              "file.")
            .required()
            .setBy("--labels", "labels beside the volume: a file, or a folder with a mask a structure");
        f.add("names", &Labels::names, anyText(),
              "Path of a file with names and colours of labels: a colour table, JSON or CSV; or "
              "totalsegmentator: those of its values.")
            .unlessDefault()
            .setBy("--label-colours", "names and colours of labels: .ctbl, .label, .json or .csv");
        f.add("look", &Labels::look, named<LabelLook>(),
              "solid: labels are a medium in their colours, whatever their values; tint: tissue as the "
              "transfer function shows it, in the labels' colours; plain: in its own colours.")
            .unlessDefault()
            .setBy("--label-look",
                   "labels as a medium in their colours, as tinted tissue, or as tissue: {names} (default: "
                   "{default})");
        f.add("opacity", &Labels::opacity, numberIn(0, 1),
              "Opacity of solid labels per mm (default: 0.999 over a voxel); of others a factor on the "
              "transfer function's extinction (default: 1).")
            .setBy("--label-opacity",
                   "opacity of labels: solid ones per mm (default: opaque), else a factor on "
                   "the preset's (default: 1)",
                   "a number from 0 to 1");
        f.add("fill", &Labels::fill, numberIn(0, 1),
              "Opacity of labels over the values of slices (default: labels.opacity, else 0.5).")
            .setBy("--label-fill", "opacity of labels in slices (default: --label-opacity, else 0.5)",
                   "a number from 0 to 1");
        f.add("outline", &Labels::outline, numberIn(0, Labels::kWidestOutline),
              "Width of the outlines of labels in slices, pixels; 0: none.")
            .unlessDefault()
            .setBy("--label-outline", "width of labels' outlines in slices, pixels; 0: none (default: 1)",
                   "a number from 0 to 16");
        f.add("borders", &Labels::borders, named<LabelBorders>(),
              "Borders of labels between voxels. smooth: where their shares are equal; nearest: the voxels' "
              "faces.")
            .unlessDefault()
            .setBy("--label-borders", "borders of labels between voxels: {names} (default: {default}); "
                                      "nearest: the voxels' faces");
        f.add("show", &Labels::show, patternsKind(),
              "The labels that show, by names with * and ?, values or group:NAME; empty: all.")
            .unlessDefault()
            .setBy("--show", "show these labels and nothing else: names with * and ?, values or group:NAME, "
                             "separated by commas");
        f.add("hide", &Labels::hide, patternsKind(), "The labels that do not show, likewise.")
            .unlessDefault()
            .setBy("--hide", "hide these labels, likewise");
        f.add("unlabelled", &Labels::unlabelled, trueOrFalse(),
              "Tissue without a label shows. Without it: it does unless labels.show names labels.");
        f.add("each", &Labels::each, listOf(objectOf(ruleFields()), Labels::kMostPatterns, "labels"),
              "Looks of some labels; of several for a label the last one counts.")
            .unlessDefault();
        f.add("sameFrame", &Labels::sameFrame, trueOrFalse(),
              "Labels are taken though their frame of reference is another than the volume's.")
            .unlessDefault()
            .setBy("--same-frame",
                   "take labels and structure sets whose frame of reference is another than the "
                   "volume's");
        return f;
    }();
    return fields;
}

} // namespace tessera
