// core/base/json_reader.cpp: see json_reader.h.
#include "core/base/json_reader.h"

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/names.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

namespace tessera {
namespace {

using nlohmann::json;

/// A short description of a value.
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

/// Follows the parser through objects and lists, to find faults that the finished document no longer shows.
/// It is a separate pass, because a callback while building the document would visit a whole list again at
/// each object in it.
class Watch : public nlohmann::json_sax<json> {
  public:
    explicit Watch(const std::string& where) : where_(where) {}

    bool start_object(std::size_t) override { return open(); }
    bool start_array(std::size_t) override { return open(); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }
    bool key(std::string& key) override {
        if (!keys_.back().insert(key).second)
            throw badFile(where_, "every key once in an object", "the key " + describe(json(key)) + " twice");
        return true;
    }
    bool null() override { return true; }
    bool boolean(bool) override { return true; }
    bool number_integer(std::int64_t) override { return true; }
    bool number_unsigned(std::uint64_t) override { return true; }
    bool number_float(double, const std::string&) override { return true; }
    bool string(std::string&) override { return true; }
    bool binary(json::binary_t&) override { return true; }
    bool parse_error(std::size_t, const std::string&, const json::exception& error) override {
        // "[json.exception.parse_error.101] parse error at line 3, column 5: ..." without the tag
        std::string message = error.what();
        if (const auto tag = message.find("] "); tag != std::string::npos)
            message = message.substr(tag + 2);
        std::replace_if(
            message.begin(), message.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
        throw badFile(where_, "JSON", "a " + message);
    }

  private:
    bool open() {
        if (keys_.size() >= static_cast<std::size_t>(kMaxJsonDepth))
            throw badFile(where_, "at most " + std::to_string(kMaxJsonDepth) + " nested levels", "more");
        keys_.emplace_back();
        return true;
    }
    bool close() {
        keys_.pop_back();
        return true;
    }

    const std::string& where_;
    std::vector<std::set<std::string>> keys_; // of the objects and lists that are open
};

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
    Watch watch(where);
    json::sax_parse(text, &watch);
    return json::parse(text);
}

std::string readTextFile(const std::string& path) {
    refusePipeOrDevice(path);
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
    return {*found, where_, below("." + key)};
}

JsonItems JsonValue::items() const {
    if (!value_->is_array())
        refuse("a list");
    return {*this, value_->size()};
}

JsonItems JsonValue::items(std::size_t most, const std::string& what) const {
    JsonItems list = items();
    if (list.size() > most)
        refuse("at most " + std::to_string(most) + " " + what);
    return list;
}

JsonValue JsonItems::operator[](std::size_t i) const {
    return {(*list_.value_)[i], list_.where_, list_.below("[" + std::to_string(i) + "]")};
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
    const std::string end =
        highest < std::numeric_limits<double>::max() ? "to " + plainNumber(highest) : "on";
    const std::string expected = "a number from " + plainNumber(lowest) + " " + end;
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
