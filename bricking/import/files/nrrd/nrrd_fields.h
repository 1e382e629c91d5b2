// bricking/import/files/nrrd/nrrd_fields.h: the words of NRRD headers: fields, types, numbers, vectors.
// For volumes and labels.
#pragma once

#include "bricking/import/files/header_words.h"
#include "bricking/import/source/slice_converter.h"

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// In lower case, without blanks: "Space Directions" is "spacedirections".
std::string nrrdFieldName(std::string_view text);
/// By its nrrdFieldName(): those of the format that the reader uses or passes over.
bool isNrrdField(const std::string& name);

/// By any of its names, in lower case; nullopt for another word, and for "block".
std::optional<FileType> nrrdTypeOf(const std::string& text);

/// "(x,y,z)" of finite numbers.
std::optional<glm::dvec3> nrrdVectorOf(std::string_view text);

/// "(1,0,0) none (0, 1, 0)": the same, blanks within brackets aside.
std::vector<std::string> vectorsOf(std::string_view text);
/// Texts in quotation marks, without them.
std::vector<std::string> textsOf(std::string_view text);

} // namespace tessera
