// viewer/cli/options/scene_words.h: settings of several keys of a scene by one word, as the options of the
// same names make them: a preset, a lighting preset, a slice.
#pragma once

#include "core/scene/scene.h"

#include <cstddef>
#include <string>
#include <vector>

namespace tessera {

/// "preset", "light" and "slice".
const std::vector<std::string>& sceneWords();
/// True of one of them, with or without its hyphens.
bool isSceneWord(const std::string& name);
/// Sets what the word means. False: the name is none, or the text is the key's own value (an object).
/// Throws InputError naming `where`.
/// @param leftOut  gets what a preset's file says and no scene can have
bool setByWord(Scene& scene, const std::string& name, const std::string& text, const std::string& where,
               std::vector<std::string>* leftOut = nullptr);

constexpr char kSliceForm[] = "axial, coronal or sagittal, with :MM where it lies, or "
                              "oblique:X,Y,Z,NX,NY,NZ (a point and a normal, mm)";
/// "axial", "axial:MM", "oblique:X,Y,Z,NX,NY,NZ". What the text does not say stays. Throws InputError naming
/// `where`.
SlicePlane parseSlice(const std::string& text, const std::string& where, SlicePlane slice = {});
/// So many numbers between commas; lengths may have their unit behind them. Throws InputError naming `where`
/// with what is expected.
std::vector<double> parseNumbers(const std::string& text, std::size_t count, const std::string& where,
                                 const std::string& expected);

} // namespace tessera
