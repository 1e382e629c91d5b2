// viewer/cli/options/scene_words.cpp: see scene_words.h.
#include "viewer/cli/options/scene_words.h"

#include "core/base/decimal.h"
#include "core/base/error.h"
#include "core/base/names.h"
#include "core/scene/scene_presets.h"
#include "core/scene/slice_view.h"
#include "viewer/cli/options/camera_words.h"
#include "viewer/cli/options/command.h"
#include "viewer/presets/preset_library.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

namespace tessera {

namespace {

struct Word {
    std::string name, key; // "": it sets several
};
const std::vector<Word>& words() {
    static const std::vector<Word> all = {
        {"preset", ""},          {"light", ""},
        {"slice", ""},           {"slab", ""},
        {"view", "camera.view"}, {"projection", "camera.parallelProjection"},
        {"fit", "camera.fit"},   {"mm-per-pixel", "camera.mmPerPixel"}};
    return all;
}

std::string withoutHyphens(const std::string& name) {
    return name.starts_with("--") ? name.substr(2) : name;
}

/// A value of a key in JSON, in place of a word.
bool isJsonValue(const std::string& text) {
    return text.starts_with('{') || text.starts_with('[') || truthOf(text);
}

/// Sets the camera. A side of the patient takes the place of a camera by position.
void setCameraByWord(Scene& scene, const std::string& word, const std::string& text,
                     const std::string& where) {
    if (word == "view") {
        FittedView view;
        if (const auto* const before = std::get_if<FittedView>(&scene.camera))
            view = *before;
        else
            view.projection = std::get<Camera>(scene.camera).projection;
        parseSide(text, view, where);
        view.named = true;
        scene.camera = view;
    } else if (word == "projection") {
        setProjection(scene, text, where);
    } else if (word == "fit") {
        setFit(scene, text, where);
    } else {
        const std::optional<double> mm = decimalNumber(withoutUnit(text, "mm"));
        if (!mm || *mm < kLeastMmPerPixel || *mm > kMostMmPerPixel)
            throw badFile(where, "mm from 0.00001 to 10000",
                          "\"" + text.substr(0, 40) + "\"" +
                              (hasDecimalComma(text) ? "; a decimal comma is not read" : ""));
        setScale(scene, *mm, true, where);
    }
}

} // namespace

std::optional<bool> truthOf(const std::string& text) {
    const auto isWord = [&](std::string_view lower) {
        return std::ranges::equal(text, lower, {}, [](char c) {
            return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        });
    };
    return isWord("true") ? std::optional(true) : isWord("false") ? std::optional(false) : std::nullopt;
}

const std::vector<std::string>& sceneWords() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const Word& word : words())
            all.push_back(word.name);
        return all;
    }();
    return names;
}

std::string wordOf(const std::string& name) {
    const std::string word = withoutHyphens(name);
    return std::ranges::count(sceneWords(), word) > 0 ? word : std::string();
}

std::string keyOfWord(const std::string& word) {
    const auto found = std::ranges::find(words(), word, &Word::name);
    return found == words().end() ? std::string() : found->key;
}

std::string wordOfKey(const std::string& key) {
    const auto found = std::ranges::find(words(), key, &Word::key);
    return found == words().end() || key.empty() ? std::string() : found->name;
}

std::string keyInPlaceOf(const std::string& name) {
    static const std::map<std::string, std::string> keys = {
        {"add", "volumes[1].path"},
        {"add-preset", "volumes[1].transferFunction"},
        {"crop", "cuts.boxes"},
        {"crop-voxels", "cuts.boxes"},
        {"cut-plane", "cuts.planes"},
        {"isosurface", "isosurfaces[0].value"},
        {"label-preset", "volumes[0].labels.each[0].transferFunction"},
        {"mesh", "meshes[0].path"},
        {"mesh-colour", "meshes[0].rgb"},
        {"mesh-contours", "meshes[0].contours"},
        {"mesh-opacity", "meshes[0].opacity"},
        {"mesh-space", "meshes[0].space"}};
    const auto found = keys.find(withoutHyphens(name));
    return found == keys.end() ? std::string() : found->second;
}

bool setByWord(Scene& scene, const std::string& name, const std::string& text, const std::string& where,
               std::vector<std::string>* leftOut) {
    const std::string word = wordOf(name);
    const bool isKey = word == "slice" || !keyOfWord(word).empty();
    if (word.empty() || (isKey && isJsonValue(text)))
        return false;
    if (word == "slice") {
        scene.slice = parseSlice(text, where);
        scene.mode = Mode::slice;
        constexpr double kAlongNormal = 1 - 1e-6;
        if (std::holds_alternative<Camera>(scene.camera) && facingOf(scene) < kAlongNormal)
            scene.camera = FittedView{}; // that of another plane
        return true;
    }
    if (word == "slab") {
        parseSlab(text, scene.slice, where);
        return true;
    }
    if (!keyOfWord(word).empty()) {
        setCameraByWord(scene, word, text, where);
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

void parseSlab(const std::string& text, SlicePlane& slice, const std::string& where) {
    const std::size_t colon = text.find(':');
    slice.thicknessMm = parseNumbers(text.substr(0, colon), 1, where, kSlabForm)[0];
    if (colon != std::string::npos)
        slice.reduction = parseName<Reduction>(text.substr(colon + 1), where);
    checkSlice(slice, where);
}

std::vector<double> parseNumbers(const std::string& text, std::size_t count, const std::string& where,
                                 const std::string& expected) {
    const std::optional<std::vector<double>> lengths = lengthsOf(text, count);
    if (!lengths)
        throw badFile(where, expected, "\"" + text.substr(0, 60) + "\"");
    return *lengths;
}

} // namespace tessera
