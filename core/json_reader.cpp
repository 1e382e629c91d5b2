// core/json_reader.cpp: see json_reader.h.
#include "core/json_reader.h"

#include "core/error.h"
#include "core/nearest_name.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

namespace tessera {
namespace {

using nlohmann::json;

/// Follows the parser through objects and lists, to see what the finished document no longer shows.
class Watch {
  public:
    explicit Watch(const std::string& where) : where_(where) {}

    bool operator()(int depth, json::parse_event_t event, const json& parsed) {
        if (event == json::parse_event_t::object_start || event == json::parse_event_t::array_start) {
            if (depth >= kMaxJsonDepth)
                throw badFile(where_, "at most " + std::to_string(kMaxJsonDepth) + " nested levels", "more");
            keys_.emplace_back();
        } else if (event == json::parse_event_t::object_end || event == json::parse_event_t::array_end) {
            keys_.pop_back();
        } else if (event == json::parse_event_t::key) {
            if (!keys_.back().insert(parsed.get<std::string>()).second)
                throw badFile(where_, "every key once in an object", "the key " + parsed.dump() + " twice");
        }
        return true;
    }

  private:
    const std::string& where_;
    std::vector<std::set<std::string>> keys_; // of the objects that are open
};

/// What a value is, short enough for a line.
std::string describe(const json& value) {
    constexpr std::size_t kMaxShown = 40;
    if (value.is_object())
        return "an object";
    if (value.is_array())
        return "a list of " + std::to_string(value.size());
    std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
    if (text.size() > kMaxShown)
        text = text.substr(0, kMaxShown) + "...";
    return text;
}

std::string plainNumber(double number) {
    std::ostringstream out;
    out.precision(10); // ranges are written by hand: no digits of rounding noise
    out << number;
    return out.str();
}

} // namespace

json parseStrictJson(const std::string& text, const std::string& where) {
    if (text.size() > kMaxJsonBytes)
        throw badFile(where, "at most 16 MiB of JSON", "more");
    try {
        Watch watch(where);
        return json::parse(text, [&watch](int depth, json::parse_event_t event, json& parsed) {
            return watch(depth, event, parsed);
        });
    } catch (const json::exception& error) {
        // "[json.exception.parse_error.101] parse error at line 3, column 5: ..."; the tag helps nobody
        std::string message = error.what();
        if (const auto tag = message.find("] "); tag != std::string::npos)
            message = message.substr(tag + 2);
        std::replace_if(
            message.begin(), message.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
        throw badFile(where, "JSON", "a " + message);
    }
}

std::string readTextFile(const std::string& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    const auto end = file ? file.tellg() : std::ifstream::pos_type(-1);
    if (end < 0)
        throw badFile(path, "a readable file", "none");
    if (static_cast<std::uintmax_t>(end) > kMaxJsonBytes)
        throw badFile(path, "at most 16 MiB of JSON",
                      std::to_string(static_cast<std::intmax_t>(end)) + " bytes");
    std::string text(static_cast<std::size_t>(end), '\0');
    file.seekg(0);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!file)
        throw badFile(path, "a readable file", "one that cannot be read");
    return text;
}

void JsonValue::refuse(const std::string& expected) const {
    throw badFile(place(), expected, describe(*value_));
}

void JsonValue::requireKeys(const std::vector<std::string>& known) const {
    if (!value_->is_object())
        refuse("an object");
    for (const auto& [key, unused] : value_->items()) {
        if (std::find(known.begin(), known.end(), key) != known.end())
            continue;
        throw badFile(place(), "a known key",
                      describe(key) + "; nearest: \"" + nearestName(key, known) + "\"");
    }
}

bool JsonValue::has(const std::string& key) const {
    return value_->is_object() && value_->contains(key);
}

JsonValue JsonValue::at(const std::string& key) const {
    if (!value_->is_object())
        refuse("an object");
    const auto found = value_->find(key);
    if (found == value_->end())
        throw badFile(place(), "the key \"" + key + "\"", "none");
    return {*found, where_, path_ + "." + key};
}

std::vector<JsonValue> JsonValue::items() const {
    if (!value_->is_array())
        refuse("a list");
    std::vector<JsonValue> values;
    values.reserve(value_->size());
    for (std::size_t i = 0; i < value_->size(); ++i)
        values.push_back({(*value_)[i], where_, path_ + "[" + std::to_string(i) + "]"});
    return values;
}

std::vector<double> JsonValue::numbers(std::size_t count) const {
    if (!value_->is_array() || value_->size() != count)
        refuse("a list of " + std::to_string(count) + " numbers");
    std::vector<double> values;
    for (const JsonValue& item : items())
        values.push_back(item.number());
    return values;
}

double JsonValue::number() const {
    if (!value_->is_number())
        refuse("a number");
    const double number = value_->get<double>();
    if (!std::isfinite(number))
        refuse("a finite number");
    return number;
}

double JsonValue::number(double lowest, double highest) const {
    const std::string expected = "a number from " + plainNumber(lowest) + " to " + plainNumber(highest);
    if (!value_->is_number())
        refuse(expected);
    const double got = number();
    if (!(got >= lowest && got <= highest))
        refuse(expected);
    return got;
}

int JsonValue::integer(int lowest, int highest) const {
    const std::string expected =
        "a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest);
    if (!value_->is_number_integer())
        refuse(expected);
    const double got = value_->get<double>(); // unsigned and signed alike; exact far beyond the range of int
    if (!(got >= lowest && got <= highest))
        refuse(expected);
    return static_cast<int>(got);
}

bool JsonValue::boolean() const {
    if (!value_->is_boolean())
        refuse("true or false");
    return value_->get<bool>();
}

std::string JsonValue::text() const {
    if (!value_->is_string())
        refuse("a text");
    return value_->get<std::string>();
}

std::string JsonValue::oneOf(const std::vector<std::string>& names) const {
    const std::string got = value_->is_string() ? value_->get<std::string>() : std::string();
    if (std::find(names.begin(), names.end(), got) != names.end())
        return got;
    if (!value_->is_string())
        refuse("one of " + joinNames(names));
    throw badFile(place(), "one of " + joinNames(names),
                  describe(*value_) + "; nearest: \"" + nearestName(got, names) + "\"");
}

void JsonValue::read(const std::string& key, double lowest, double highest, double& target) const {
    if (has(key))
        target = at(key).number(lowest, highest);
}
void JsonValue::read(const std::string& key, bool& target) const {
    if (has(key))
        target = at(key).boolean();
}

bool JsonValue::isText() const {
    return value_->is_string();
}
bool JsonValue::isObject() const {
    return value_->is_object();
}
bool JsonValue::isList() const {
    return value_->is_array();
}

} // namespace tessera
