// viewer/cli/options/scene_words.h: settings of a scene by words, as the options of the same names make them:
// a preset, a lighting preset, a slice and its slab, and the camera.
#pragma once

#include "core/scene/scene.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// "true" and "false" in any case: programs that make tables write TRUE. None: another text.
std::optional<bool> truthOf(const std::string& text);

/// "preset", "light", "slice", "slab", "view", "projection", "fit" and "mm-per-pixel".
const std::vector<std::string>& sceneWords();
/// The word of a name, with or without its hyphens; "": it is none.
std::string wordOf(const std::string& name);
/// The one key that a word sets ("view": "camera.view"); "": several, or it is no word.
std::string keyOfWord(const std::string& word);
/// The word that sets a key; "": there is none.
std::string wordOfKey(const std::string& key);
/// The key to use in place of an option that sets others: "crop": "cuts.boxes"; "": there is none.
std::string keyInPlaceOf(const std::string& name);
/// Sets what the word means. False: the name is none, or one of a key whose value the text is in JSON (an
/// object, a list, true or false). Throws InputError naming `where`.
/// @param leftOut  gets what a preset's file says and no scene can have
bool setByWord(Scene& scene, const std::string& name, const std::string& text, const std::string& where,
               std::vector<std::string>* leftOut = nullptr);

constexpr char kSliceForm[] = "axial, coronal or sagittal, with :MM where it lies, or "
                              "oblique:X,Y,Z,NX,NY,NZ (a point and a normal, mm)";
constexpr char kSlabForm[] = "MM, MM:average, MM:maximum or MM:minimum";
/// Thickness and reduction of the slice. Throws InputError naming `where`.
void parseSlab(const std::string& text, SlicePlane& slice, const std::string& where);
/// "axial", "axial:MM", "oblique:X,Y,Z,NX,NY,NZ". What the text does not say stays. Throws InputError naming
/// `where`.
SlicePlane parseSlice(const std::string& text, const std::string& where, SlicePlane slice = {});
/// So many numbers between commas; lengths may have their unit behind them. Throws InputError naming `where`
/// with what is expected.
std::vector<double> parseNumbers(const std::string& text, std::size_t count, const std::string& where,
                                 const std::string& expected);

} // namespace tessera
