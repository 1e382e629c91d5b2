// core/base/names.h: names that users type: the known name that is nearest to a mistyped one, for "did you
// mean", and an enum's values and their names in files, options and messages, in one table.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tessera {

/// Insertions, deletions and replacements of single characters that turn a into b; ASCII case is ignored.
/// Both are cut at 64 characters first, so that a hostile word costs nothing.
std::size_t editDistance(std::string_view a, std::string_view b);
/// The known name with the smallest editDistance (the first of equals); "" when known is empty.
std::string nearestName(std::string_view word, const std::vector<std::string>& known);
/// The index of text in names. Throws InputError naming where, and the nearest name, if it is missing.
std::size_t indexOfName(const std::string& text, const std::vector<std::string>& names,
                        const std::string& where);
/// "a, b, c": for messages that list what is known.
std::string joinNames(const std::vector<std::string>& names);

template <typename Enum> class NameTable {
  public:
    using Rows = std::initializer_list<std::pair<Enum, const char*>>;
    /// @param others  aliases, accepted where a user types them
    NameTable(Rows rows, Rows others = {}) {
        for (const auto& [value, name] : rows) {
            values_.push_back(value);
            names_.emplace_back(name);
        }
        for (const auto& [value, name] : others)
            others_.emplace_back(value, name);
    }
    const std::vector<std::string>& all() const { return names_; }
    /// @param value  one of the table
    const std::string& of(Enum value) const {
        std::size_t at = 0;
        while (values_.at(at) != value)
            ++at;
        return names_[at];
    }
    /// Of a name alone. Throws InputError naming where and the nearest name.
    Enum named(const std::string& name, const std::string& where) const {
        return values_[indexOfName(name, names_, where)];
    }
    /// Accepts aliases too.
    Enum parse(const std::string& text, const std::string& where) const {
        for (const auto& [value, word] : others_)
            if (word == text)
                return value;
        return named(text, where);
    }

  private:
    std::vector<Enum> values_;
    std::vector<std::string> names_;
    std::vector<std::pair<Enum, std::string>> others_;
};

/// The table of an enum; specialised beside its names.
template <typename Enum> const NameTable<Enum>& namesOf();
/// Accepts aliases too. Throws InputError naming where and the nearest name.
template <typename Enum> Enum parseName(const std::string& text, const std::string& where) {
    return namesOf<Enum>().parse(text, where);
}
template <typename Enum> const std::string& nameOf(Enum value) {
    return namesOf<Enum>().of(value);
}

} // namespace tessera
