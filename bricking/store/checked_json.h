// bricking/store/checked_json.h: access to JSON from files: every refusal gives the place and what was
// expected. Internal to bricking's .cpp files.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace tessera {

using Json = nlohmann::json; // keys sorted, so that dump() is canonical

/// Throws InputError naming where.
Json parseJson(std::string_view text, const std::string& where);
/// The value at a JSON pointer. Throws InputError naming where and the pointer.
const Json& jsonAt(const Json& document, const std::string& pointer, const std::string& where);
std::int64_t integerAt(const Json& document, const std::string& pointer, std::int64_t lowest,
                       std::int64_t highest, const std::string& where);
double numberAt(const Json& document, const std::string& pointer, const std::string& where);
std::string textAt(const Json& document, const std::string& pointer, const std::string& where);
bool flagAt(const Json& document, const std::string& pointer, const std::string& where);

/// The text of a document in a store.
std::string storedText(const Json& document);

/// Sets attributes.tessera.checksum to the CRC-32C of the canonical text of all the rest.
void seal(Json& document);
/// Throws InputError naming where if the checksum is missing or wrong.
void checkSeal(const Json& document, const std::string& where);
/// Throws InputError that names the first key in which found differs from expected.
void checkEqual(const Json& found, const Json& expected, const std::string& where);

} // namespace tessera
