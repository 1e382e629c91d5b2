// viewer/cli/batch/text_pattern.h: texts with places for the cells of a row: "out/{id}.png". "{{" and "}}"
// are braces.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

class TextPattern {
  public:
    TextPattern() = default;
    /// @param names  of columns, which may stand between braces, as may "row", the row's number from 1
    /// @param kept   of other places, with their braces, which stay as they are
    /// Throws InputError naming `where` for other names, with the nearest, and for a brace alone.
    TextPattern(const std::string& text, const std::vector<std::string>& names, const std::string& where,
                const std::vector<std::string>& kept = {});

    bool hasPlaces() const { return parts_.size() > 1; }
    bool uses(std::size_t column) const;
    /// The text before its first place.
    const std::string& begin() const { return parts_.front().before; }
    std::string fill(const std::vector<std::string>& cells, std::size_t row) const;

  private:
    static constexpr std::size_t kNone = static_cast<std::size_t>(-1), kRow = kNone - 1;
    struct Part {
        std::string before;
        std::size_t column = kNone; // behind it; kRow: the row's number
    };
    std::vector<Part> parts_{Part{}};
};

/// The names of files for rows: the folder of a pattern's begin, and below it whatever the cells say.
class OutputPattern {
  public:
    /// Throws InputError naming `-o` as TextPattern does, and for a pattern that goes up behind a place.
    OutputPattern(const std::string& text, const std::vector<std::string>& names);

    bool uses(std::size_t column) const { return pattern_.uses(column); }
    /// Throws InputError naming `where` for a name that leaves the folder: a cell that is empty, begins
    /// with a point or has a slash or a control character, and parts of the path that are empty, ".", ".." or
    /// longer than a name may be.
    std::filesystem::path fill(const std::vector<std::string>& cells, std::size_t row,
                               const std::string& where) const;

  private:
    TextPattern pattern_;
    std::filesystem::path folder_;
    std::size_t folderLength_ = 0; // of the pattern's text
};

} // namespace tessera
