// viewer/cli/options/scene_words.cpp: see scene_words.h.
#include "viewer/cli/options/scene_words.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/scene/scene_presets.h"
#include "core/scene/slice_view.h"
#include "viewer/cli/options/command.h"
#include "viewer/presets/preset_library.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

namespace tessera {

const std::vector<std::string>& sceneWords() {
    static const std::vector<std::string> words = {"preset", "light", "slice"};
    return words;
}

bool isSceneWord(const std::string& name) {
    const std::string word = name.starts_with("--") ? name.substr(2) : name;
    return std::find(sceneWords().begin(), sceneWords().end(), word) != sceneWords().end();
}

bool setByWord(Scene& scene, const std::string& name, const std::string& text, const std::string& where,
               std::vector<std::string>* leftOut) {
    if (!isSceneWord(name) || text.starts_with('{'))
        return false;
    const std::string word = name.starts_with("--") ? name.substr(2) : name;
    if (word == "slice") {
        scene.slice = parseSlice(text, where);
        scene.mode = Mode::slice;
        constexpr double kAlongNormal = 1 - 1e-6;
        if (std::holds_alternative<Camera>(scene.camera) && facingOf(scene) < kAlongNormal)
            scene.camera = FittedView{}; // that of another plane
        return true;
    }
    try {
        if (word == "light") {
            indexOfName(text, lookNames(), where);
            applyLook(text, scene);
        } else if (isOwnOrFile(text)) {
            FoundPreset found = findPreset(text);
            applyPreset(found.preset, scene);
            if (leftOut)
                *leftOut = std::move(found.leftOut);
        } else { // a name stays a name, so that its function suits the volume's values
            applyBuiltInPreset(text, text, scene);
        }
    } catch (const InputError& e) {
        std::string why = e.what();
        if (why.starts_with("preset: "))
            why.erase(0, sizeof "preset: " - 1);
        throw InputError(why.starts_with(where) ? why : where + ": " + why);
    }
    return true;
}

SlicePlane parseSlice(const std::string& text, const std::string& where, SlicePlane slice) {
    const std::size_t colon = text.find(':');
    const std::string rest = colon == std::string::npos ? std::string() : text.substr(colon + 1);
    slice.orientation = parseName<Orientation>(text.substr(0, colon), where);
    slice.positionMm.reset();
    if (colon != std::string::npos && rest.empty())
        throw badFile(where, kSliceForm, "\"" + text.substr(0, 60) + "\"");
    if (slice.orientation == Orientation::oblique) {
        const std::vector<double> n = parseNumbers(rest.empty() ? "?" : rest, 6, where, kSliceForm);
        slice.point = {n[0], n[1], n[2]};
        slice.normal = {n[3], n[4], n[5]};
    } else if (!rest.empty()) {
        slice.positionMm = parseNumbers(rest, 1, where, kSliceForm)[0];
    }
    checkSlice(slice, where);
    return slice;
}

std::vector<double> parseNumbers(const std::string& text, std::size_t count, const std::string& where,
                                 const std::string& expected) {
    const std::optional<std::vector<double>> lengths = lengthsOf(text, count);
    if (!lengths)
        throw badFile(where, expected, "\"" + text.substr(0, 60) + "\"");
    return *lengths;
}

} // namespace tessera
