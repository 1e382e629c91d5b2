// viewer/cli/batch/text_pattern.cpp: see text_pattern.h.
#include "viewer/cli/batch/text_pattern.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <sstream>
#include <utility>

namespace tessera {
namespace {

/// Neither hidden nor elsewhere.
bool isPartOfName(const std::string& cell) {
    return !cell.empty() && cell.front() != '.' &&
           std::ranges::none_of(cell, [](unsigned char c) { return c == '/' || c < ' ' || c == 0x7f; });
}

} // namespace

TextPattern::TextPattern(const std::string& text, const std::vector<std::string>& names,
                         const std::string& where, const std::vector<std::string>& kept) {
    const auto refuse = [&](const std::string& found) {
        throw badFile(where, "names of columns in braces ({{ and }} are braces)", found);
    };
    for (std::size_t n = 0; n < text.size(); ++n) {
        const bool isDouble = n + 1 < text.size() && text[n + 1] == text[n];
        if (text[n] == '}' && !isDouble)
            refuse("\"}\" alone");
        if ((text[n] != '{' && text[n] != '}') || isDouble) {
            parts_.back().before += text[n];
            n += isDouble && (text[n] == '{' || text[n] == '}') ? 1 : 0;
            continue;
        }
        const std::size_t end = text.find('}', n);
        if (end == std::string::npos)
            refuse("\"{\" alone");
        const std::string name = text.substr(n + 1, end - n - 1);
        const auto column = std::ranges::find(names, name);
        if (column == names.end() && std::ranges::count(kept, "{" + name + "}") > 0) {
            parts_.back().before += "{" + name + "}";
            n = end;
            continue;
        }
        if (column == names.end() && name != "row") {
            std::vector<std::string> known = names;
            known.emplace_back("row");
            throw badFile(where, "a column of the table",
                          "{" + name.substr(0, 60) + "}; nearest: {" + nearestName(name, known) + "}");
        }
        parts_.back().column =
            column == names.end() ? kRow : static_cast<std::size_t>(column - names.begin());
        parts_.emplace_back();
        n = end;
    }
}

bool TextPattern::uses(std::size_t column) const {
    return std::ranges::any_of(parts_, [&](const Part& part) { return part.column == column; });
}

std::string TextPattern::fill(const std::vector<std::string>& cells, std::size_t row) const {
    std::string text;
    for (const Part& part : parts_) {
        text += part.before;
        if (part.column == kRow)
            text += std::to_string(row + 1);
        else if (part.column != kNone)
            text += cells.at(part.column);
    }
    return text;
}

OutputPattern::OutputPattern(const std::string& text, const std::vector<std::string>& names)
    : pattern_(text, names, "-o") {
    const std::string& begin = pattern_.begin();
    folderLength_ = begin.rfind('/') == std::string::npos ? 0 : begin.rfind('/') + 1;
    folder_ =
        folderLength_ == 0 ? std::filesystem::path() : std::filesystem::path(begin.substr(0, folderLength_));
    if (("/" + text.substr(std::min(text.size(), folderLength_)) + "/").find("/../") != std::string::npos)
        throw badFile("-o", "a pattern that stays in its folder", "\"..\" behind a column");
}

std::filesystem::path OutputPattern::fill(const std::vector<std::string>& cells, std::size_t row,
                                          const std::string& where) const {
    constexpr std::size_t kLongestName = 200; // bytes; temporary names are longer
    for (std::size_t n = 0; n < cells.size(); ++n)
        if (pattern_.uses(n) && !isPartOfName(cells[n]))
            throw badFile(where, "a part of a file's name",
                          cells[n].empty() ? "an empty cell"
                                           : "\"" + printable(cells[n].substr(0, 60)) + "\"");
    const std::string text = pattern_.fill(cells, row).substr(folderLength_);
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, '/');)
        if (part.empty() || part == "." || part == ".." || part.size() > kLongestName)
            throw badFile(where, "a file's name of at most " + std::to_string(kLongestName) + " bytes",
                          "\"" + part.substr(0, 60) + "\"");
    return folder_ / text;
}

} // namespace tessera
