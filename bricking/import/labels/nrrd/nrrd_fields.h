// bricking/import/labels/nrrd/nrrd_fields.h: the words of NRRD headers: fields, types, numbers, vectors.
// Private to the NRRD reader.
#pragma once

#include "bricking/import/source/slice_converter.h"

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

std::string_view withoutBlanks(std::string_view text);
std::string lowered(std::string_view text);
/// In lower case, without blanks: "Space Directions" is "spacedirections".
std::string nrrdFieldName(std::string_view text);
/// By its nrrdFieldName(): those of the format that the reader uses or passes over.
bool isNrrdField(const std::string& name);

/// By any of its names, in lower case; nullopt for another word, and for "block".
std::optional<FileType> nrrdTypeOf(const std::string& text);

/// The whole text as a number, with a sign or without; nullopt for another text.
std::optional<std::int64_t> wholeNumberOf(std::string_view text);
/// Not finite numbers too.
std::optional<double> realNumberOf(std::string_view text);
/// "(x,y,z)" of finite numbers.
std::optional<glm::dvec3> nrrdVectorOf(std::string_view text);

/// Words between blanks.
std::vector<std::string> wordsOf(std::string_view text);
/// "(1,0,0) none (0, 1, 0)": the same, blanks within brackets aside.
std::vector<std::string> vectorsOf(std::string_view text);
/// Texts in quotation marks, without them.
std::vector<std::string> textsOf(std::string_view text);

/// A pattern with one %d, %i or %u, with a width or without, for a number from 0 on; nullopt for others.
std::optional<std::string> numberedName(const std::string& pattern, std::int64_t number);

} // namespace tessera
