// core/image/page_manifest.cpp: the manifest of a PDF or SVG that viewer/annotations/ wrote, for
// picture_codecs.h: the Keywords of a PDF's document information (ISO 32000-1, 14.3.3), found by its table of
// objects (7.5.4); the text of an SVG's <metadata id="tessera-manifest">.
#include "core/image/picture_codecs.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint64_t kMostManifestBytes = 32u << 20; // one has some thousands, four times that as digits
constexpr std::uint64_t kMostObjects = 1u << 20;        // of a PDF; a figure has tens

/// A file of which parts are read.
class Parts {
  public:
    explicit Parts(const std::string& path) : in_(path, std::ios::binary) {
        if (!in_)
            throw PictureProblem("a file that cannot be opened");
        in_.seekg(0, std::ios::end);
        size_ = static_cast<std::uint64_t>(std::max<std::streamoff>(0, in_.tellg()));
    }
    std::uint64_t size() const { return size_; }
    /// As many bytes as there are of these.
    std::string read(std::uint64_t from, std::uint64_t count) {
        std::string bytes(static_cast<std::size_t>(std::min(count, size_ - std::min(from, size_))), '\0');
        in_.clear();
        in_.seekg(static_cast<std::streamoff>(from));
        in_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        if (!in_ && !bytes.empty())
            throw PictureProblem("a file that cannot be read");
        return bytes;
    }

  private:
    std::ifstream in_;
    std::uint64_t size_ = 0;
};

bool isSpace(char c) {
    return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\f' || c == '\0';
}

/// Reads the words of a PDF from the front of a text.
class PdfWords {
  public:
    explicit PdfWords(std::string_view text) : text_(text) {}
    std::string_view left() const { return text_; }

    void skipSpace() {
        while (!text_.empty() && isSpace(text_.front()))
            text_.remove_prefix(1);
    }
    bool take(std::string_view word) {
        skipSpace();
        if (!text_.starts_with(word))
            return false;
        text_.remove_prefix(word.size());
        return true;
    }
    std::optional<std::uint64_t> number() {
        skipSpace();
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
        if (error != std::errc())
            return std::nullopt;
        text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
        return value;
    }
    /// Up to the next space or delimiter.
    std::string_view name() {
        const std::size_t end =
            std::min(text_.find_first_of(std::string_view(" \n\r\t\f\0()<>[]/", 13)), text_.size());
        const std::string_view name = text_.substr(0, end);
        text_.remove_prefix(end);
        return name;
    }
    /// "(...)", with brackets in pairs and escapes; nullopt where it has no end.
    std::optional<std::string> literal() {
        if (!take("("))
            return std::nullopt;
        std::string out;
        for (int depth = 1; !text_.empty();) {
            char c = text_.front();
            text_.remove_prefix(1);
            if (c == '\\' && !text_.empty()) {
                c = text_.front();
                text_.remove_prefix(1);
                constexpr std::string_view kLetters = "nrtbf", kMeant = "\n\r\t\b\f";
                if (const std::size_t at = kLetters.find(c); at != std::string_view::npos)
                    c = kMeant[at];
                else if (c >= '0' && c <= '7')
                    c = octal(c);
                else if (c == '\n')
                    continue;
            } else if (c == '(') {
                ++depth;
            } else if (c == ')' && --depth == 0) {
                return out;
            }
            out += c;
        }
        return std::nullopt;
    }

    /// "<FEFF...>", digits of UTF-16, big endian, of ASCII alone; "" for other bytes, nullopt where it has no
    /// end.
    std::optional<std::string> digits() {
        constexpr std::string_view kMark = "<FEFF";
        const std::size_t end = text_.find('>');
        if (end == std::string_view::npos)
            return std::nullopt;
        std::string_view units = text_.substr(0, end);
        text_.remove_prefix(end + 1);
        if (!units.starts_with(kMark))
            return std::string();
        std::string out;
        for (units.remove_prefix(kMark.size()); units.size() >= 4; units.remove_prefix(4)) {
            unsigned unit = 0;
            const auto [last, error] = std::from_chars(units.data(), units.data() + 4, unit, 16);
            if (error != std::errc() || last != units.data() + 4 || unit == 0 || unit > 127)
                return std::string();
            out += static_cast<char>(unit);
        }
        return units.empty() ? out : std::string();
    }

  private:
    char octal(char first) {
        int value = first - '0';
        for (int digit = 1; digit < 3 && !text_.empty() && text_.front() >= '0' && text_.front() <= '7';
             ++digit) {
            value = 8 * value + text_.front() - '0';
            text_.remove_prefix(1);
        }
        return static_cast<char>(value);
    }
    std::string_view text_;
};

const char* const kTooSoon = "a PDF that ends too soon";
const char* const kOtherPdf = "a PDF without a plain table of objects, as Tessera writes it";

/// Where the last table of objects is.
std::uint64_t tableOffset(Parts& file) {
    constexpr std::uint64_t kTail = 1024;
    const std::string tail = file.read(file.size() - std::min(kTail, file.size()), kTail);
    const std::size_t at = tail.rfind("startxref");
    if (at == std::string::npos)
        throw PictureProblem(kTooSoon);
    PdfWords words(std::string_view(tail).substr(at));
    words.take("startxref");
    const auto offset = words.number();
    if (!offset || !words.take("%%EOF") || *offset >= file.size())
        throw PictureProblem(kTooSoon);
    return *offset;
}

/// The offset of an object by a table's text; nullopt: it has none.
std::optional<std::uint64_t> offsetOf(std::string_view table, std::uint64_t object) {
    constexpr std::size_t kEntry = 20; // "0000000015 00000 n \n"
    PdfWords words(table);
    if (!words.take("xref"))
        throw PictureProblem(kOtherPdf);
    while (!words.take("trailer")) {
        const auto first = words.number(), count = words.number();
        if (!first || !count || *count > kMostObjects)
            throw PictureProblem(kOtherPdf);
        words.skipSpace();
        const std::string_view entries = words.left();
        if (entries.size() / kEntry < *count)
            throw PictureProblem(kTooSoon);
        if (object >= *first && object - *first < *count) {
            PdfWords entry(entries.substr(static_cast<std::size_t>(object - *first) * kEntry, kEntry));
            const auto offset = entry.number();
            return offset && entry.number() && entry.take("n") ? offset : std::nullopt;
        }
        words = PdfWords(entries.substr(static_cast<std::size_t>(*count) * kEntry));
    }
    return std::nullopt;
}

/// The Keywords of an object that is a dictionary of names and plain values.
std::string keywordsOf(std::string_view object, std::uint64_t number) {
    PdfWords words(object);
    if (words.number() != number || !words.number() || !words.take("obj") || !words.take("<<"))
        throw PictureProblem("a PDF whose table of objects is wrong");
    while (!words.take(">>")) {
        if (!words.take("/"))
            throw PictureProblem(kOtherPdf);
        const std::string_view key = words.name();
        words.skipSpace();
        if (const bool literal = words.left().starts_with('('); literal || words.left().starts_with('<')) {
            std::optional<std::string> value = literal ? words.literal() : words.digits();
            if (!value)
                throw PictureProblem(kTooSoon);
            if (key == "Keywords")
                return *std::move(value);
        } else { // a number, a name, a reference: up to the next key or the end
            const std::size_t end = words.left().find_first_of("/>", 1);
            if (end == std::string_view::npos)
                throw PictureProblem(kTooSoon);
            words = PdfWords(words.left().substr(end));
        }
    }
    return {};
}

std::string unescaped(std::string_view text) {
    constexpr std::pair<std::string_view, char> kEntities[] = {
        {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}};
    std::string out;
    while (!text.empty()) {
        const auto* const entity = std::find_if(std::begin(kEntities), std::end(kEntities),
                                                [&](const auto& e) { return text.starts_with(e.first); });
        if (entity != std::end(kEntities)) {
            out += entity->second;
            text.remove_prefix(entity->first.size());
        } else if (text.front() == '&' || text.front() == '<') {
            throw PictureProblem("an SVG whose metadata are not plain text");
        } else {
            out += text.front();
            text.remove_prefix(1);
        }
    }
    return out;
}

} // namespace

std::string pdfManifest(const std::string& path) {
    Parts file(path);
    if (!file.read(0, 5).starts_with("%PDF-"))
        throw PictureProblem("another file, not a PDF");
    const std::uint64_t at = tableOffset(file);
    const std::string table = file.read(at, kMostManifestBytes);
    const std::size_t trailer = table.find("trailer");
    if (trailer == std::string::npos)
        throw PictureProblem(kOtherPdf);
    const std::size_t info = table.find("/Info", trailer);
    if (info == std::string::npos)
        return {};
    PdfWords words(std::string_view(table).substr(info));
    words.take("/Info");
    const auto number = words.number();
    if (!number)
        throw PictureProblem(kOtherPdf);
    const auto offset = offsetOf(table, *number);
    if (!offset || *offset >= file.size())
        throw PictureProblem("a PDF whose table of objects is wrong");
    std::string keywords = keywordsOf(file.read(*offset, kMostManifestBytes), *number);
    return keywords.starts_with('{') ? keywords : std::string(); // else the keywords of another program
}

std::string svgManifest(const std::string& path) {
    constexpr std::uint64_t kHead = 1 << 16, kTail = 256;
    constexpr std::string_view kBegin = "<metadata id=\"tessera-manifest\">", kEnd = "</metadata>";
    Parts file(path);
    const std::string head = file.read(0, kHead);
    if (head.find("<svg") == std::string::npos)
        throw PictureProblem("another file, not an SVG");
    if (file.read(file.size() - std::min(kTail, file.size()), kTail).find("</svg>") == std::string::npos)
        throw PictureProblem("an SVG that ends too soon");
    const std::size_t begin = head.find(kBegin);
    if (begin == std::string::npos)
        return {};
    const std::string text = file.read(begin + kBegin.size(), kMostManifestBytes);
    const std::size_t end = text.find(kEnd);
    if (end == std::string::npos)
        throw PictureProblem("an SVG whose metadata have no end");
    return unescaped(std::string_view(text).substr(0, end));
}

} // namespace tessera
