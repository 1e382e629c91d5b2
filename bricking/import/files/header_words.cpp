// bricking/import/files/header_words.cpp: see header_words.h.
#include "bricking/import/files/header_words.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <charconv>
#include <system_error>

namespace tessera {
namespace {

constexpr std::size_t kMostHeaderBytes = std::size_t{16} << 20, kPortionBytes = 64 * 1024;
constexpr std::string_view kBlanks = " \t\r\v\f";

template <class T> std::optional<T> numberIn(std::string_view text) {
    text = withoutBlanks(text);
    if (text.starts_with('+') && !text.starts_with("+-"))
        text.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

} // namespace

std::string_view withoutBlanks(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos)
        return {};
    return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

std::string lowered(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return out;
}

std::optional<std::int64_t> wholeNumberOf(std::string_view text) {
    return numberIn<std::int64_t>(text);
}

std::optional<double> realNumberOf(std::string_view text) {
    return numberIn<double>(text);
}

std::vector<std::string> wordsOf(std::string_view text) {
    std::vector<std::string> words;
    for (;;) {
        const std::size_t begin = text.find_first_not_of(kBlanks);
        if (begin == std::string_view::npos)
            return words;
        text.remove_prefix(begin);
        const std::size_t end = std::min(text.find_first_of(kBlanks), text.size());
        words.emplace_back(text.substr(0, end));
        text.remove_prefix(end);
    }
}

std::string shownWord(std::string_view text) {
    constexpr std::size_t kMostShown = 60;
    return "\"" + printable(text.substr(0, kMostShown)) + (text.size() > kMostShown ? "..." : "") + "\"";
}

std::optional<std::string> HeaderLines::next() {
    std::size_t end = text_.find('\n', at_);
    for (std::size_t seen = at_; end == std::string::npos; end = text_.find('\n', seen)) {
        seen = text_.size();
        if (seen > kMostHeaderBytes)
            throw badFile(file_.path().string(), "a header (" + format_ + ") of 16 MiB at most",
                          "a longer one");
        text_.resize(seen + kPortionBytes);
        const auto room = std::as_writable_bytes(std::span(text_)).subspan(seen);
        text_.resize(seen + file_.readSome(seen, room));
        if (text_.size() == seen)
            break;
    }
    if (at_ == text_.size())
        return std::nullopt;
    std::string line = text_.substr(at_, end == std::string::npos ? end : end - at_);
    at_ = end == std::string::npos ? text_.size() : end + 1;
    if (line.ends_with('\r'))
        line.pop_back();
    return line;
}

std::optional<std::string> numberedName(const std::string& pattern, std::int64_t number) {
    const std::size_t begin = pattern.find('%');
    if (begin == std::string::npos)
        return std::nullopt;
    std::size_t end = begin + 1;
    const bool hasZeros = end < pattern.size() && pattern[end] == '0';
    std::size_t width = 0;
    constexpr std::size_t kMostWidth = 20;
    for (; end < pattern.size() && pattern[end] >= '0' && pattern[end] <= '9'; ++end)
        width = std::min(kMostWidth, 10 * width + static_cast<std::size_t>(pattern[end] - '0'));
    if (end == pattern.size() || std::string_view("diu").find(pattern[end]) == std::string_view::npos ||
        pattern.find('%', end) != std::string::npos)
        return std::nullopt;
    std::string digits = std::to_string(number);
    if (digits.size() < width)
        digits.insert(0, width - digits.size(), hasZeros ? '0' : ' ');
    return pattern.substr(0, begin) + digits + pattern.substr(end + 1);
}

} // namespace tessera
