// core/base/json_reader.h: strict, typed reading of our own JSON files (scenes, presets). Every refusal names
// the file, the JSON path, what was expected and what was found. Include from .cpp files only.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

constexpr std::size_t kMaxJsonBytes = std::size_t{16} << 20; // a transfer function of 2e5 points is 5 MiB
constexpr int kMaxJsonDepth = 16;                            // our own files nest 5 deep

/// Parses a document. Throws InputError naming where for text that is no JSON, is larger than kMaxJsonBytes,
/// nests deeper than kMaxJsonDepth, or has an object with the same key twice.
nlohmann::json parseStrictJson(const std::string& text, const std::string& where);
/// A whole file as text. Throws InputError naming it if it cannot be read or is larger than kMaxJsonBytes.
std::string readTextFile(const std::string& path);

class JsonItems;

/// A value in a document, with its path ("$.camera.position[2]"). The document must outlive it.
class JsonValue {
  public:
    JsonValue(const nlohmann::json& document, std::string where)
        : JsonValue(document, std::move(where), "$") {}
    /// A value that a user typed after an option: messages name only the option, and aliases of names are
    /// accepted.
    static JsonValue typed(const nlohmann::json& document, std::string option) {
        return {document, std::move(option), ""};
    }

    /// All of these throw InputError if the value is of another kind. Checks that it is an object with no
    /// other keys than these.
    void requireKeys(const std::vector<std::string>& known) const;
    bool has(const std::string& key) const;
    JsonValue at(const std::string& key) const;
    JsonItems items() const;
    /// The same of a list of limited length, which is checked before any item is read.
    /// @param what  "isosurfaces", for the message
    JsonItems items(std::size_t most, const std::string& what) const;
    /// A list of exactly count numbers, any of them finite.
    std::vector<double> numbers(std::size_t count) const;
    /// @param highest  the largest double: no bound
    double number(double lowest, double highest) const;
    double number() const;
    int integer(int lowest, int highest) const;
    bool boolean() const;
    std::string text() const;
    /// One of the names.
    std::string oneOf(const std::vector<std::string>& names) const;

    bool isText() const;
    bool isObject() const;
    bool isList() const;
    bool isTyped() const { return path_.empty(); }
    /// "FILE: $.path", for messages.
    std::string place() const { return isTyped() ? where_ : where_ + ": " + path_; }
    [[noreturn]] void refuse(const std::string& expected) const;

    /// Sets target if the key is there.
    void read(const std::string& key, double lowest, double highest, double& target) const;
    void read(const std::string& key, bool& target) const;

  private:
    friend class JsonItems;
    JsonValue(const nlohmann::json& value, std::string where, std::string path)
        : value_(&value), where_(std::move(where)), path_(std::move(path)) {}
    std::string below(const std::string& step) const { return isTyped() ? "" : path_ + step; }
    const nlohmann::json* value_;
    std::string where_, path_;
};

/// The values of a list, made on demand: a hostile list may be as long as its file is large.
class JsonItems {
  public:
    JsonItems(JsonValue list, std::size_t size) : list_(std::move(list)), size_(size) {}
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    /// @param i  below size()
    JsonValue operator[](std::size_t i) const;
    JsonValue front() const { return (*this)[0]; }

    class Iterator {
      public:
        Iterator(const JsonItems& items, std::size_t at) : items_(&items), at_(at) {}
        JsonValue operator*() const { return (*items_)[at_]; }
        Iterator& operator++() {
            ++at_;
            return *this;
        }
        bool operator==(const Iterator& other) const { return at_ == other.at_; }

      private:
        const JsonItems* items_;
        std::size_t at_;
    };
    Iterator begin() const { return {*this, 0}; }
    Iterator end() const { return {*this, size_}; }

  private:
    JsonValue list_;
    std::size_t size_;
};

} // namespace tessera
