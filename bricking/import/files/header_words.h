// bricking/import/files/header_words.h: words of headers that are text (NRRD, MetaImage, Volume Graphics):
// numbers, lists, and patterns of file names.
#pragma once

#include "bricking/import/source/source_files.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

std::string_view withoutBlanks(std::string_view text);
std::string lowered(std::string_view text);

/// The whole text as a number, with a sign or without; nullopt for another text.
std::optional<std::int64_t> wholeNumberOf(std::string_view text);
/// Not finite numbers too.
std::optional<double> realNumberOf(std::string_view text);

/// Words between blanks.
std::vector<std::string> wordsOf(std::string_view text);

/// In quotation marks, printable and short, for messages.
std::string shownWord(std::string_view text);

/// Lines of a header, read as they are needed.
class HeaderLines {
  public:
    /// @param format  "NRRD", for messages
    /// @param file  must outlive it
    HeaderLines(const InputFile& file, std::string format) : file_(file), format_(std::move(format)) {}

    /// The next line without its end; nullopt at the end of the file. Throws InputError naming the file for a
    /// header of more than 16 MiB.
    std::optional<std::string> next();
    std::uint64_t readBytes() const { return at_; }

  private:
    const InputFile& file_;
    std::string format_;
    std::string text_;
    std::size_t at_ = 0;
};

/// A pattern with one %d, %i or %u, with a width or without, for a number from 0 on; nullopt for others.
std::optional<std::string> numberedName(const std::string& pattern, std::int64_t number);

} // namespace tessera
