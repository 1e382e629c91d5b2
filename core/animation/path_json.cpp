// core/animation/path_json.cpp: paths as JSON, by their table of keys: see path.h, path_fields.h.
#include "core/animation/path_fields.h"

#include "core/base/error.h"

#include <glm/vec2.hpp>

namespace tessera {

template <> const NameTable<Easing>& namesOf<Easing>() {
    static const NameTable<Easing> names{{{Easing::through, "through"},
                                          {Easing::smooth, "smooth"},
                                          {Easing::linear, "linear"},
                                          {Easing::hold, "hold"}}};
    return names;
}
template <> const NameTable<Lumen::Side>& namesOf<Lumen::Side>() {
    static const NameTable<Lumen::Side> names{{{Lumen::Side::below, "below"}, {Lumen::Side::above, "above"}}};
    return names;
}

namespace {

constexpr double kMostPathMm = 1e7, kMostSeconds = 1e6;
constexpr int kMostIndex = 1000000;

Kind<glm::ivec3> voxelsKind() {
    const Kind<std::vector<int>> list = listOf(wholeIn(1, 1 << 30), 3, 3, "[x, y, z] in voxels");
    return {[=](const JsonValue& value) {
                const std::vector<int> size = list.read(value);
                return glm::ivec3(size[0], size[1], size[2]);
            },
            [](const glm::ivec3& size) {
                return nlohmann::json::array({size.x, size.y, size.z});
            },
            list.schema};
}
/// The number of a line.
Kind<std::size_t> lineNumber() {
    const Kind<int> number = wholeIn(0, kMostIndex);
    return {[=](const JsonValue& value) { return static_cast<std::size_t>(number.read(value)); },
            [](std::size_t line) { return nlohmann::json(line); }, number.schema};
}

const Fields<PathVolume>& pathVolumeFields() {
    static const Fields<PathVolume> fields = [] {
        Fields<PathVolume> f("pathVolume", "The volume that the lines were made in.");
        f.add("contentHash", &PathVolume::contentHash, anyText(),
              "Content hash of the store, as in tessera info and manifests.")
            .required();
        f.add("size", &PathVolume::extentVoxels, voxelsKind(), "Extent, voxels.").required();
        return f;
    }();
    return fields;
}

const Fields<Lumen>& lumenFields() {
    static const Fields<Lumen> fields = [] {
        Fields<Lumen> f("lumen", "The values that count as lumen.");
        f.add("threshold", &Lumen::threshold, anyNumber(), "Threshold of the lumen, physical units.")
            .required();
        f.add("side", &Lumen::side, named<Lumen::Side>(),
              "Side of the threshold on which the lumen's values are.")
            .required();
        f.add("noise", &Lumen::noise, numberIn(0, 1e30),
              "Standard deviation of the noise that was removed before values were compared with the "
              "threshold, physical units. Without it: none was removed.")
            .writtenIf([](const Lumen& lumen) { return lumen.noise > 0; });
        f.add("surface", &Lumen::surface, anyNumber(),
              "Isovalue that shows the wall in the volume's own values, with their noise, physical units. "
              "Without it: the threshold.");
        f.add("branchesTo", &Lumen::branchesTo, anyNumber(),
              "Value up to which thin branches of a tree were followed beyond the threshold, physical units. "
              "Without it: no such branches.");
        f.add("branchWall", &Lumen::branchWall, anyNumber(),
              "Least difference between the values around a thin branch and its own, physical units. Without "
              "it: by the lumen's first point.");
        f.add("leaks", &Lumen::leaks, trueOrFalse(),
              "The lumen leaks through its wall: lines may lie outside it.")
            .unlessDefault();
        f.add("leavesAt", &Lumen::leavesAtMm, numberIn(0, kMostPathMm),
              "Where the first line of a leaking lumen leaves the lumen of a threshold that does not leak, "
              "mm along the line.");
        f.add("unsure", &Lumen::unsure, trueOrFalse(),
              "The threshold hardly differs from the noise of the values in the lumen.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

const Fields<CentreLine>& lineFields() {
    static const Fields<CentreLine> fields = [] {
        Fields<CentreLine> f("line", "One branch, as evenly spaced points.");
        f.add("name", &CentreLine::name, anyText(), "A name for people.").unlessDefault();
        f.add("spacing", &CentreLine::spacingMm, numberIn(1e-3, 1e4),
              "Distance between points along the line, mm. The straight distance is at least half of it, and "
              "at most all of it.")
            .required();
        f.add("points", &CentreLine::points,
              listOf(numbersWithin<glm::dvec3>(-kMostPathMm, kMostPathMm, "[x, y, z] in mm", &glm::dvec3::x,
                                               &glm::dvec3::y, &glm::dvec3::z))
                  .described({{"minItems", CentreLine::kFewestPoints}}),
              "Points, mm.")
            .required();
        f.add("radius", &CentreLine::radiusMm,
              listOf(numberIn(0, kMostPathMm)).described({{"minItems", CentreLine::kFewestPoints}}),
              "Distance of each point to the wall, mm, where values cross the threshold. If the threshold "
              "was tightened because of a leak: to half way between the values of lumen and wall.")
            .required();
        const Kind<int> count = wholeIn(0, kMostIndex);
        f.add({"count", "Number of points.",
               [=](const JsonValue& value, const CentreLine&) { count.read(value); },
               [](const CentreLine& line) { return nlohmann::json(line.points.size()); }, count.schema})
            .required();
        f.add("parent", &CentreLine::parent, lineNumber(),
              "Number of the parent line, from 0, an earlier one. Without it: a root.");
        f.add("leavesAt", &CentreLine::leavesAtMm, numberIn(0, kMostPathMm),
              "Distance along the parent at which the line leaves it, mm; with parent only.")
            .writtenIf([](const CentreLine& line) { return line.parent.has_value(); });
        f.rule([](const JsonValue& whole, const CentreLine& line) {
            const int said = whole.at("count").integer(0, kMostIndex);
            if (static_cast<std::size_t>(said) != line.points.size())
                whole.at("points").refuse("as many points as \"count\" says, " + std::to_string(said));
            if (whole.has("parent") != whole.has("leavesAt"))
                whole.refuse("both \"parent\" and \"leavesAt\", or neither");
        });
        return f;
    }();
    return fields;
}

/// All lines, which have so many points together.
Kind<std::vector<CentreLine>> linesKind() {
    Kind<std::vector<CentreLine>> kind = listOf(objectOf(lineFields()), Path::kMostLines, "lines");
    kind.read = [](const JsonValue& value) {
        std::vector<CentreLine> lines;
        std::size_t points = 0;
        for (const JsonValue& item : value.items(Path::kMostLines, "lines")) {
            lines.push_back(lineFields().read(item));
            points += lines.back().points.size();
            if (points > Path::kMostPoints)
                item.at("points").refuse("at most " + std::to_string(Path::kMostPoints) +
                                         " points in all lines");
        }
        return lines;
    };
    return kind;
}

const Fields<LookAround>& lookFields() {
    static const Fields<LookAround> fields = [] {
        Fields<LookAround> f("look", "Direction and offset of the camera on a flown line.");
        f.add("yaw", &LookAround::yawDegrees, numberIn(-360, 360), "To the right, degrees.");
        f.add("pitch", &LookAround::pitchDegrees, numberIn(-89, 89), "Up, degrees.");
        f.add("offset", &LookAround::offsetMm,
              numbersWithin<glm::dvec2>(-1e4, 1e4, "[right, up] in mm", &glm::dvec2::x, &glm::dvec2::y),
              "[right, up], mm; held within the wall.");
        return f;
    }();
    return fields;
}

const Fields<Keyframe>& keyframeFields() {
    static const Fields<Keyframe> fields = [] {
        Fields<Keyframe> f("keyframe", "Settings at a moment. What a keyframe leaves out is interpolated "
                                       "from its neighbours; what all leave out is the scene's.");
        f.add("time", &Keyframe::timeS, numberIn(0, kMostSeconds),
              "Time from the film's beginning, s. Each keyframe has a time or a place.");
        f.add("place", &Keyframe::placeMm, numberIn(0, kMostPathMm),
              "Distance along the flown route from its first point, mm.");
        f.add("easing", &Keyframe::easing, named<Easing>(),
              "Transition to the next keyframe. through: without a halt; smooth: from rest to rest; linear: "
              "at one speed; hold: a jump at the next.");
        f.add("camera", &Keyframe::camera, objectOf(freeCameraFields()),
              "Camera; only where no line is flown.");
        f.add("look", &Keyframe::look, objectOf(lookFields()));
        f.add("transferFunction", &Keyframe::transferFunction, transferKind(),
              "The name of a preset, or the points.");
        f.add("lighting", &Keyframe::lighting, objectOf(lightingFields()));
        f.add("cuts", &Keyframe::cuts, objectOf(cutsFields()));
        return f;
    }();
    return fields;
}

const Fields<Flight>& flightFields() {
    static const Fields<Flight> fields = [] {
        Fields<Flight> f("flight", "Flight along the lines.");
        f.add("route", &Flight::route, listOf(lineNumber()).described({{"minItems", 1}}),
              "Lines to fly along, by number, each a child of the one before.");
        f.add("backwards", &Flight::backwards, trueOrFalse(), "Fly from the route's end to its beginning.");
        f.add("from", &Flight::fromMm, numberIn(0, kMostPathMm),
              "Start along the route, from its first point, mm.");
        f.add("to", &Flight::toMm, numberIn(0, kMostPathMm),
              "End along the route, mm. Without it: the route's end.");
        f.add("speed", &Flight::speedMmPerS, numberIn(0.01, 1e5), "Speed, mm/s.");
        f.add("viewAngle", &Flight::viewAngle, numberIn(1, Path::kMostViewAngle),
              "Full vertical angle of view, degrees.");
        f.add("lookAhead", &Flight::lookAheadMm, numberIn(0, 1e4),
              "Distance along the line to the point that the camera looks at, mm.");
        f.add("clearance", &Flight::clearanceMm, numberIn(0, 1e4),
              "Least distance to the wall, mm, where the lumen is wide enough.");
        return f;
    }();
    return fields;
}

} // namespace

const Fields<Path>& pathFields() {
    static const Fields<Path> fields = [] {
        Fields<Path> f("path");
        f.add({"tesseraPath", "Version of this format.",
               [](const JsonValue& value, const Path&) { value.integer(Path::kVersion, Path::kVersion); },
               [](const Path&) { return nlohmann::json(Path::kVersion); },
               [](Schema&) {
                   return Schema{{"const", Path::kVersion}};
               }})
            .required();
        f.add("volume", &Path::volume, objectOf(pathVolumeFields()));
        f.add("lumen", &Path::lumen, objectOf(lumenFields()));
        f.add("lines", &Path::lines, linesKind(), "Centre-lines of branches.").unlessDefault();
        f.add("keyframes", &Path::keyframes,
              listOf(objectOf(keyframeFields()), Path::kMostKeyframes, "keyframes"),
              "Keyframes in order of time or place.")
            .unlessDefault();
        f.add("flight", &Path::flight, objectOf(flightFields()));
        f.add("framesPerSecond", &Path::framesPerSecond, numberIn(0.1, 1000), "Frame rate of the film.");
        return f;
    }();
    return fields;
}

Path parsePath(const std::string& text, const std::string& where) {
    const nlohmann::json document = parseStrictJson(text, where);
    Path path = pathFields().read({document, where});
    checkPath(path, where);
    return path;
}

Path loadPath(const std::filesystem::path& file) {
    return parsePath(readTextFile(file.string()), file.string());
}

std::string pathJson(const Path& path) {
    return pathFields().write(path).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

namespace {
/// Definitions of the scene's schema are references to it.
Schema withReferences(const Schema& schema, const Schema& elsewhere) {
    const std::string prefix = "#/$defs/";
    Schema out = schema;
    for (const auto& [key, value] : schema.items())
        if (value.is_structured()) {
            Schema& inner = schema.is_object() ? out[key] : out[std::stoul(key)];
            inner = withReferences(value, elsewhere);
        } else if (key == "$ref" && elsewhere.contains(value.get<std::string>().substr(prefix.size()))) {
            out[key] = "scene.schema.json" + value.get<std::string>();
        }
    return out;
}
} // namespace

Schema pathSchema() {
    Schema parts = Schema::object();
    Schema root = pathFields().schema(parts);
    const Schema& ofScenes = sceneSchema()["$defs"];
    for (const auto& [name, unused] : ofScenes.items())
        parts.erase(name);
    return withReferences(
        documentSchema("Tessera path, version 1",
                       "Paths through a volume: centre-lines of hollow organs, keyframes, and flight "
                       "parameters. Lengths are millimetres in DICOM patient space (LPS). A path has lines "
                       "or keyframes, or both; a flight follows a line.",
                       std::move(root), std::move(parts)),
        ofScenes);
}

} // namespace tessera
