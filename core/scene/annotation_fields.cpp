// core/scene/annotation_fields.cpp: the keys of annotations: see scene_fields.h.
#include "core/scene/annotations.h"
#include "core/scene/scene_fields.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

constexpr double kMostArrowMm = 1e6;
constexpr std::size_t kMostLetters = Annotations::kMostLetters;

Kind<std::string> words() {
    return anyText()
        .checked([](const std::string& text, const JsonValue& value) {
            if (text.size() > kMostLetters)
                value.refuse("at most " + std::to_string(kMostLetters) + " letters");
        })
        .described({{"maxLength", kMostLetters}});
}

/// A colour, or background: none of its own.
Kind<std::optional<glm::vec3>> stripColour() {
    constexpr const char* kBackground = "background";
    const Kind<std::optional<glm::vec3>> colours = backgroundKind();
    return {
        [=](const JsonValue& value) -> std::optional<glm::vec3> {
            if (!value.isList() && value.text() == kBackground)
                return std::nullopt;
            const std::optional<glm::vec3> colour = colours.read(value);
            if (!colour)
                value.refuse("a colour, or background");
            return colour;
        },
        [=](const std::optional<glm::vec3>& colour) -> nlohmann::json {
            return colour ? colours.write(colour) : nlohmann::json(kBackground);
        },
        [](Schema& parts) {
            const char* const words = "^(#[0-9a-fA-F]{6}|[a-zA-Z]+)$";
            return Schema{{"oneOf", {{{"type", "string"}, {"pattern", words}}, colourKind().schema(parts)}}};
        }};
}

const Fields<Arrow>& arrowFields() {
    static const Fields<Arrow> fields = [] {
        Fields<Arrow> f("arrow");
        f.add("place", &Arrow::place,
              numbersWithin<glm::dvec3>(-kMostArrowMm, kMostArrowMm, "[x, y, z], mm", &glm::dvec3::x,
                                        &glm::dvec3::y, &glm::dvec3::z),
              "Place in patient space (LPS) that it points at, mm.")
            .required();
        f.add("offset", &Arrow::offset,
              numbersWithin<glm::dvec2>(-1e4, 1e4, "[x, y], points", &glm::dvec2::x, &glm::dvec2::y),
              "From there to its other end, 1/72 inch; x to the right, y down.");
        f.add("text", &Arrow::text, words(), "Words at its other end.");
        return f;
    }();
    return fields;
}

} // namespace

template <> const NameTable<Directions>& namesOf<Directions>() {
    static const NameTable<Directions> names{{{Directions::none, "none"},
                                              {Directions::letters, "letters"},
                                              {Directions::cube, "cube"},
                                              {Directions::all, "all"}}};
    return names;
}

template <> const NameTable<AnnotationMargin>& namesOf<AnnotationMargin>() {
    static const NameTable<AnnotationMargin> names{{{AnnotationMargin::none, "none"},
                                                    {AnnotationMargin::legends, "legends"},
                                                    {AnnotationMargin::all, "all"}}};
    return names;
}

bool Annotations::namesPhase() const {
    const auto names = [](const std::string& text) { return text.find(kPhasePlace) != std::string::npos; };
    return names(title) || names(caption) ||
           std::ranges::any_of(arrows, [&](const Arrow& arrow) { return names(arrow.text); });
}

bool Annotations::namePhase(const std::string& label) {
    Annotations named = *this;
    bool fits = true;
    const auto name = [&](std::string& text) {
        const std::size_t length = std::string_view(kPhasePlace).size();
        for (std::size_t at = text.find(kPhasePlace); at != std::string::npos;
             at = text.find(kPhasePlace, at + label.size()))
            text.replace(at, length, label);
        fits = fits && text.size() <= kMostLetters;
    };
    name(named.title);
    name(named.caption);
    for (Arrow& arrow : named.arrows)
        name(arrow.text);
    if (fits)
        *this = std::move(named);
    return fits;
}

bool Annotations::any() const {
    return scaleBar || directions != Directions::none || legend || labelLegend || measurements || error ||
           !title.empty() || !caption.empty() || !arrows.empty();
}

const Fields<Annotations>& annotationFields() {
    static const Fields<Annotations> fields = [] {
        Fields<Annotations> f("annotations", "What a figure shows over its picture.");
        f.add("scaleBar", &Annotations::scaleBar, trueOrFalse(),
              "A bar of a round length; it holds everywhere in a parallel picture, else at the depth of the "
              "camera's focal point.")
            .setBy("--scale-bar", "draw a bar of a round length; it holds everywhere in a parallel picture, "
                                  "else at the centre");
        f.add("directions", &Annotations::directions, named<Directions>(),
              "The patient's directions: letters at the picture's edges, a cube, or both.")
            .setBy("--directions", "the patient's directions: {names} (default: {default})");
        f.add("legend", &Annotations::legend, trueOrFalse(),
              "Colours by value of every volume that shows, or the window of single values.")
            .setBy("--legend", "draw a bar of the transfer function's colours, or of the window");
        f.add("labelLegend", &Annotations::labelLegend, trueOrFalse(),
              "Names and colours of the labels that are drawn.")
            .setBy("--label-legend", "draw names and colours of the labels that show");
        f.add("measurements", &Annotations::measurements, trueOrFalse(), "The scene's measurements.")
            .setBy("--measurements", "draw the scene's measurements");
        f.add("error", &Annotations::error, trueOrFalse(), "The measured error, in the caption.")
            .setBy("--error-caption", "write the measured error into the caption");
        f.add("title", &Annotations::title, words(), "Words at the picture's top.")
            .setBy("--title", "words at the top");
        f.add("caption", &Annotations::caption, words(), "Words at its bottom.")
            .setBy("--caption", "words at the bottom");
        f.add("arrows", &Annotations::arrows, listOf(objectOf(arrowFields()), Arrow::kMost, "arrows"),
              "Arrows to places in the patient.");
        f.add("margin", &Annotations::margin, named<AnnotationMargin>(),
              "What stands beside the picture, on strips around it, in place of over it: the legends, at the "
              "right; or all but measurements, arrows and the words of pictures along a line.")
            .setBy("--margin", "put annotations beside the picture, whose file grows by strips: {names} "
                               "(default: {default})");
        f.add("marginColour", &Annotations::marginColour, stripColour(),
              "Colour of these strips; that of the background by default.")
            .setBy("--margin-colour", "colour of these strips, as --background (default: the background's)");
        f.add("textPoints", &Annotations::textPoints, numberIn(1, 200), "Height of letters, 1/72 inch.");
        f.add("dpi", &Annotations::dpi, numberIn(10, 10000),
              "Pixels per inch of the figure, by which letters and lines have their size; a file of the "
              "picture keeps it.")
            .setBy("--dpi", "pixels per inch of the figure, for the size of letters (default: {default})",
                   "pixels per inch from 10 to 10000");
        return f;
    }();
    return fields;
}

} // namespace tessera
