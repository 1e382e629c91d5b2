// core/base/json_fields.h: objects of our JSON files as tables with a row per key: its member, the kind of
// its value and one sentence. Reading, writing and the published schema follow from the rows. Include from
// .cpp files only.
#pragma once

#include "core/base/json_reader.h"
#include "core/base/names.h"

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace tessera {

/// JSON Schema (2020-12), its keys in the order that people read them.
using Schema = nlohmann::ordered_json;

/// The representation of a value of type T in a file.
template <typename T> struct Kind {
    using Type = T;
    /// Throws InputError naming the place for any other value.
    std::function<T(const JsonValue&)> read;
    std::function<nlohmann::json(const T&)> write;
    /// @param parts  definitions that it refers to are added
    std::function<Schema(Schema& parts)> schema;

    /// The same, with a further check, which may refuse.
    Kind checked(std::function<void(const T&, const JsonValue&)> check) const {
        Kind kind = *this;
        kind.read = [before = read, check = std::move(check)](const JsonValue& value) {
            T read = before(value);
            check(read, value);
            return read;
        };
        return kind;
    }
    /// The same, with more entries in its schema.
    Kind described(const Schema& more) const {
        Kind kind = *this;
        kind.schema = [before = schema, more](Schema& parts) {
            Schema all = before(parts);
            all.update(more);
            return all;
        };
        return kind;
    }
};

Kind<double> anyNumber(); // finite
Kind<double> numberIn(double lowest, double highest);
Kind<double> numberFrom(double lowest); // finite
Kind<int> wholeIn(int lowest, int highest);
Kind<bool> trueOrFalse();
Kind<std::string> anyText();
Kind<std::string> oneOf(const std::vector<std::string>& names);

template <typename Enum> Kind<Enum> named() {
    const Kind<std::string> text = oneOf(namesOf<Enum>().all());
    return {[text](const JsonValue& v) {
                return v.isTyped() && v.isText() ? parseName<Enum>(v.text(), v.place())
                                                 : namesOf<Enum>().named(text.read(v), v.place());
            },
            [](const Enum& value) { return nlohmann::json(nameOf(value)); }, text.schema};
}

/// A list of as many numbers as there are places: pointers to members, or functions that return references.
template <typename T, typename... Place> Kind<T> numbersAt(Place... places) {
    return {[=](const JsonValue& value) {
                const std::vector<double> numbers = value.numbers(sizeof...(Place));
                T out{};
                std::size_t next = 0;
                ((std::invoke(places, out) = numbers[next++]), ...);
                return out;
            },
            [=](const T& value) { return nlohmann::json::array({std::invoke(places, value)...}); },
            [](Schema&) {
                return Schema{{"type", "array"},
                              {"items", {{"type", "number"}}},
                              {"minItems", sizeof...(Place)},
                              {"maxItems", sizeof...(Place)}};
            }};
}
/// The same within bounds. `expected`, such as "[x, y, z], mm", is for the message.
template <typename T, typename... Place>
Kind<T> numbersWithin(double lowest, double highest, const std::string& expected, Place... places) {
    Kind<T> kind = numbersAt<T>(places...);
    const Kind<double> one = numberIn(lowest, highest);
    kind.read = [=](const JsonValue& value) {
        if (!value.isList() || value.items().size() != sizeof...(Place))
            value.refuse(expected);
        T out{};
        std::size_t next = 0;
        ((std::invoke(places, out) = one.read(value.items()[next++])), ...);
        return out;
    };
    Schema parts;
    return kind.described({{"items", one.schema(parts)}});
}

/// A list of limited length, which is checked before any item is read.
/// @param expected  "at most 8 isosurfaces"
template <typename T>
Kind<std::vector<T>> listOf(const Kind<T>& kind, std::size_t least, std::size_t most,
                            const std::string& expected) {
    return {[=](const JsonValue& value) {
                const JsonItems items = value.items();
                if (items.size() < least || items.size() > most)
                    value.refuse(expected);
                std::vector<T> list;
                for (const JsonValue& item : items)
                    list.push_back(kind.read(item));
                return list;
            },
            [=](const std::vector<T>& list) {
                nlohmann::json out = nlohmann::json::array();
                for (const T& item : list)
                    out.push_back(kind.write(item));
                return out;
            },
            [=](Schema& parts) {
                Schema schema = {{"type", "array"}};
                if (least > 0)
                    schema["minItems"] = least;
                if (most < kMaxJsonBytes)
                    schema["maxItems"] = most;
                schema["items"] = kind.schema(parts);
                return schema;
            }};
}
template <typename T>
Kind<std::vector<T>> listOf(const Kind<T>& kind, std::size_t most, const std::string& what) {
    return listOf(kind, 0, most, "at most " + std::to_string(most) + " " + what);
}
template <typename T> Kind<std::vector<T>> listOf(const Kind<T>& kind) {
    return listOf(kind, 0, kMaxJsonBytes, "");
}

/// The command-line option that sets a key, for programs that take it.
struct KeyOption {
    std::string name = {};  // "--step"; "": the key has none
    std::string about = {}; // for help; "{names}" and "{default}" stand for those of the key
    std::string range = {}; // of a number, for messages: "voxels from 1/64 to 16"; "": in the key's words
};
/// The key of a schema's property that holds its option. It is not published.
inline constexpr const char* kOptionKey = "x-option";

/// A row of a table.
template <typename T> struct Field {
    std::string key, about;
    /// Of the value at the key; of what an object holds. Null is left out.
    std::function<void(const JsonValue& value, T& object)> read = {};
    std::function<nlohmann::json(const T& object)> write = {};
    std::function<Schema(Schema& parts)> schema = {};
    bool isRequired = false, onlyUnlikeDefault = false, saysDefault = true;
    std::function<bool(const T&)> isWritten = {};
    std::function<void(const T&, const JsonValue& whole)> isAllowed = {};
    KeyOption option = {};

    /// The key is required.
    Field& required() {
        isRequired = true;
        return *this;
    }
    /// Files leave the key out if it has the default value.
    Field& unlessDefault() {
        onlyUnlikeDefault = true;
        return *this;
    }
    /// A missing key has another meaning than the member's default: no default is published.
    Field& withoutDefault() {
        saysDefault = false;
        return *this;
    }
    Field& writtenIf(std::function<bool(const T&)> condition) {
        isWritten = std::move(condition);
        return *this;
    }
    /// Throws InputError if the values of earlier rows do not allow the key.
    Field& allowedBy(std::function<void(const T&, const JsonValue& whole)> check) {
        isAllowed = std::move(check);
        return *this;
    }
    /// An option sets the key, too. One of a key that is true or false is a flag for the value that is not
    /// the default: "--no-shading".
    Field& setBy(const std::string& name, const std::string& about, const std::string& range = {}) {
        option = {name, about, range};
        return *this;
    }
};

/// The keys of an object.
template <typename T> class Fields {
  public:
    /// @param name  in the schema: "shading"
    /// @param start  the object without any key
    explicit Fields(std::string name, std::string about = {}, T start = {})
        : name_(std::move(name)), about_(std::move(about)), start_(std::move(start)) {}

    /// @param place  pointer to a member, or a function that returns a reference to it; an optional member is
    /// written if it has a value
    template <typename Place, typename Value>
    Field<T>& add(const std::string& key, Place place, const Kind<Value>& kind, std::string about = {}) {
        using Member = std::remove_cvref_t<std::invoke_result_t<Place, T&>>;
        Field<T> field{key, std::move(about)};
        field.read = [=](const JsonValue& value, T& object) {
            std::invoke(place, object) = static_cast<Member>(kind.read(value));
        };
        field.write = [=](const T& object) -> nlohmann::json {
            const Member& member = std::invoke(place, object);
            if constexpr (std::is_same_v<Member, std::optional<Value>>)
                return member ? kind.write(*member) : nlohmann::json();
            else
                return kind.write(static_cast<Value>(member));
        };
        field.schema = kind.schema;
        return add(std::move(field));
    }
    Field<T>& add(Field<T> field) {
        rows_.push_back(std::move(field));
        return rows_.back();
    }
    /// A key whose value is an object with keys of this struct: nested in the file, not in memory.
    Field<T>& part(const std::string& key, const Fields<T>& fields) {
        Field<T> field{key, {}};
        field.read = [fields](const JsonValue& value, T& object) { fields.readInto(value, object); };
        field.write = [fields](const T& object) { return fields.write(object); };
        field.schema = [fields](Schema& parts) { return fields.reference(parts); };
        return add(std::move(field));
    }
    /// A check across keys. Throws InputError.
    void rule(std::function<void(const JsonValue& whole, T& object)> rule) { rule_ = std::move(rule); }
    /// Further entries of the object's schema.
    void describe(const Schema& more) { more_ = more; }

    const std::string& name() const { return name_; }
    const std::vector<Field<T>>& rows() const { return rows_; }
    std::vector<std::string> keys() const {
        std::vector<std::string> keys;
        for (const Field<T>& row : rows_)
            keys.push_back(row.key);
        return keys;
    }

    /// Throws InputError naming the place for an unknown key, with the nearest known one, a missing key, or a
    /// refused value.
    T read(const JsonValue& whole) const {
        T object = start_;
        readInto(whole, object);
        return object;
    }
    void readInto(const JsonValue& whole, T& object) const {
        whole.requireKeys(keys());
        readKnown(whole, object);
    }
    /// Other keys are the caller's affair.
    void readKnown(const JsonValue& whole, T& object) const {
        for (const Field<T>& row : rows_) {
            if (!row.isRequired && !whole.has(row.key))
                continue;
            if (row.isAllowed)
                row.isAllowed(object, whole);
            row.read(whole.at(row.key), object);
        }
        if (rule_)
            rule_(whole, object);
    }
    nlohmann::json write(const T& object) const {
        nlohmann::json out = nlohmann::json::object();
        for (const Field<T>& row : rows_)
            if (nlohmann::json value = written(row, object);
                !value.is_null() && !(row.onlyUnlikeDefault && value == written(row, start_)))
                out[row.key] = std::move(value);
        return out;
    }

    Schema schema(Schema& parts) const {
        Schema required = Schema::array(), properties = Schema::object();
        for (const Field<T>& row : rows_) {
            Schema& property = properties[row.key] = Schema::object();
            if (!row.about.empty())
                property["description"] = row.about;
            property.update(row.schema(parts));
            if (row.isRequired)
                required.push_back(row.key);
            else if (const nlohmann::json value = written(row, start_);
                     row.saysDefault && !value.empty() && !value.is_object())
                property["default"] = value;
            if (!row.option.name.empty())
                property[kOptionKey] = {row.option.name, row.option.about, row.option.range};
        }
        Schema schema;
        if (!about_.empty())
            schema["description"] = about_;
        schema["type"] = "object";
        if (!required.empty())
            schema["required"] = required;
        schema.update(more_);
        schema["additionalProperties"] = false;
        schema["properties"] = properties;
        return schema;
    }
    /// {"$ref": "#/$defs/shading"}; what it refers to is among the parts.
    Schema reference(Schema& parts) const {
        if (!parts.contains(name_)) {
            parts[name_] = {}; // in order of appearance
            parts[name_] = schema(parts);
        }
        return {{"$ref", "#/$defs/" + name_}};
    }

  private:
    nlohmann::json written(const Field<T>& row, const T& object) const {
        return row.isWritten && !row.isWritten(object) ? nlohmann::json() : row.write(object);
    }

    std::string name_, about_;
    T start_;
    Schema more_ = Schema::object();
    std::vector<Field<T>> rows_;
    std::function<void(const JsonValue&, T&)> rule_;
};

/// An object by a table, which must outlive it.
template <typename T> Kind<T> objectOf(const Fields<T>& fields) {
    return {[&fields](const JsonValue& value) { return fields.read(value); },
            [&fields](const T& value) { return fields.write(value); },
            [&fields](Schema& parts) { return fields.reference(parts); }};
}

} // namespace tessera
