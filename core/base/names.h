// core/base/names.h: an enum's values and their names in files, options and messages, in one table.
#pragma once

#include "core/base/nearest_name.h"

#include <cstddef>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

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
