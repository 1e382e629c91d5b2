// bricking/store/checked_json.cpp: see checked_json.h.
#include "bricking/store/checked_json.h"

#include "bricking/store/codec.h"
#include "core/base/error.h"

#include <cmath>
#include <cstdio>

namespace tessera {
namespace {

const char* const kSealPath = "/attributes/tessera/checksum";

std::string sealOf(Json document) {
    document["attributes"]["tessera"].erase("checksum");
    const std::string text = document.dump();
    char out[32];
    std::snprintf(out, sizeof out, "crc32c:%08x",
                  static_cast<unsigned>(crc32c(std::as_bytes(std::span(text)))));
    return out;
}

std::string brief(const Json& value) {
    std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
    if (text.size() > 80)
        text = text.substr(0, 77) + "...";
    return text;
}

} // namespace

Json parseJson(std::string_view text, const std::string& where) {
    try {
        return Json::parse(text);
    } catch (const Json::exception& problem) {
        throw badFile(where, "JSON", std::string("text that is not (") + problem.what() + ")");
    }
}

const Json& jsonAt(const Json& document, const std::string& pointer, const std::string& where) {
    const Json::json_pointer at(pointer);
    if (!document.contains(at))
        throw badFile(where, "the key " + pointer, "none");
    return document.at(at);
}

std::int64_t integerAt(const Json& document, const std::string& pointer, std::int64_t lowest,
                       std::int64_t highest, const std::string& where) {
    const Json& value = jsonAt(document, pointer, where);
    const bool fits = value.is_number_unsigned()
                          ? value.get<std::uint64_t>() <= static_cast<std::uint64_t>(INT64_MAX)
                          : value.is_number_integer();
    if (!fits || value.get<std::int64_t>() < lowest || value.get<std::int64_t>() > highest)
        throw badFile(where,
                      pointer + " to be an integer from " + std::to_string(lowest) + " to " +
                          std::to_string(highest),
                      brief(value));
    return value.get<std::int64_t>();
}

double numberAt(const Json& document, const std::string& pointer, const std::string& where) {
    const Json& value = jsonAt(document, pointer, where);
    if (!value.is_number() || !std::isfinite(value.get<double>()))
        throw badFile(where, pointer + " to be a finite number", brief(value));
    return value.get<double>();
}

std::string textAt(const Json& document, const std::string& pointer, const std::string& where) {
    const Json& value = jsonAt(document, pointer, where);
    if (!value.is_string())
        throw badFile(where, pointer + " to be a text", brief(value));
    return value.get<std::string>();
}

bool flagAt(const Json& document, const std::string& pointer, const std::string& where) {
    const Json& value = jsonAt(document, pointer, where);
    if (!value.is_boolean())
        throw badFile(where, pointer + " to be true or false", brief(value));
    return value.get<bool>();
}

std::string storedText(const Json& document) {
    return document.dump(1) + "\n";
}

void seal(Json& document) {
    document["attributes"]["tessera"]["checksum"] = sealOf(document);
}

void checkSeal(const Json& document, const std::string& where) {
    const std::string expected = textAt(document, kSealPath, where);
    if (const std::string found = sealOf(document); found != expected)
        throw badFile(where, "metadata with checksum " + expected,
                      found + "; the file is damaged or was edited");
}

void checkEqual(const Json& found, const Json& expected, const std::string& where) {
    if (found == expected)
        return;
    const Json difference = Json::diff(expected, found);
    std::string pointer = difference.empty() ? "/" : difference.at(0).at("path").get<std::string>();
    const Json::json_pointer at(pointer.empty() ? "" : pointer);
    throw badFile(where, pointer + " to be " + (expected.contains(at) ? brief(expected.at(at)) : "left out"),
                  found.contains(at) ? brief(found.at(at)) : "nothing");
}

} // namespace tessera
