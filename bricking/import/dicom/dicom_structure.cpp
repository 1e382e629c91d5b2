// bricking/import/dicom/dicom_structure.cpp: see dicom_structure.h.
#include "bricking/import/dicom/dicom_structure.h"

#include "bricking/import/source/source_files.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <functional>
#include <string_view>
#include <vector>

namespace tessera {
namespace {

constexpr std::uint64_t kMarkEnd = 132; // preamble and mark
constexpr std::uint32_t kUndefined = 0xFFFFFFFF;
constexpr std::uint32_t kSyntaxTag = 0x00020010, kPixelTag = 0x7FE00010, kItem = 0xFFFEE000,
                        kItemEnd = 0xFFFEE00D, kSequenceEnd = 0xFFFEE0DD;
constexpr std::uint32_t kMostUidBytes = 1024; // longer lists are not checked
constexpr int kMostNested = 16;
constexpr std::uint64_t kBlockBytes = 512; // tapes and some archives fill files up to a multiple of it

/// Value representations: their name, whether their length has 32 bits, and the size of one value.
struct Representation {
    std::string_view name;
    bool isLong;
    std::uint32_t valueBytes;
};
constexpr std::array<Representation, 34> kRepresentations = {
    {{"AE", false, 1}, {"AS", false, 1}, {"AT", false, 4}, {"CS", false, 1}, {"DA", false, 1},
     {"DS", false, 1}, {"DT", false, 1}, {"FD", false, 8}, {"FL", false, 4}, {"IS", false, 1},
     {"LO", false, 1}, {"LT", false, 1}, {"OB", true, 1},  {"OD", true, 8},  {"OF", true, 4},
     {"OL", true, 4},  {"OV", true, 8},  {"OW", true, 2},  {"PN", false, 1}, {"SH", false, 1},
     {"SL", false, 4}, {"SQ", true, 1},  {"SS", false, 2}, {"ST", false, 1}, {"SV", true, 8},
     {"TM", false, 1}, {"UC", true, 1},  {"UI", false, 1}, {"UL", false, 4}, {"UN", true, 1},
     {"UR", true, 1},  {"US", false, 2}, {"UT", true, 1},  {"UV", true, 8}}};

constexpr const char* kImplicitSyntax = "1.2.840.10008.1.2";
constexpr const char* kBigEndianSyntax = "1.2.840.10008.1.2.2";
constexpr const char* kDeflated = "1.2.840.10008.1.2.1.99";

/// The check cannot continue; caught by structureOf().
struct Irregular {
    std::string words;
    bool breaksOff = false;
};

std::string tagText(std::uint32_t tag) {
    char text[16];
    std::snprintf(text, sizeof text, "(%04x,%04x)", tag >> 16, tag & 0xffff);
    return text;
}

/// The bytes of a file or of memory, by position, through a window.
class Source {
  public:
    using Read = std::function<std::size_t(std::uint64_t, std::span<std::byte>)>;
    Source(std::uint64_t size, Read read) : size_(size), read_(std::move(read)) {}

    std::uint64_t size() const { return size_; }
    std::uint64_t heads = 0; // of elements that were read
    const std::byte* at(std::uint64_t offset, std::size_t count) {
        if (offset > size_ || count > size_ - offset)
            throw Irregular{"an element that goes beyond the end of the file", true};
        if (offset < begin_ || offset + count > begin_ + window_.size()) {
            window_.resize(
                std::max(count, static_cast<std::size_t>(std::min<std::uint64_t>(size_ - offset, 8192))));
            begin_ = offset;
            read_(offset, window_);
        }
        return window_.data() + (offset - begin_);
    }

  private:
    std::uint64_t size_, begin_ = 0;
    Read read_;
    std::vector<std::byte> window_;
};

/// One element's head.
struct Element {
    std::uint32_t tag = 0, length = 0;
    bool isSequence = false, isUnknown = false; // unknown (UN) sequences are written implicitly
    bool isUid = false;
    std::uint64_t content = 0; // where it begins
};

/// Digits and points, several UIDs separated by backslashes, the last one padded to an even length.
bool isUids(const std::byte* text, std::size_t length) {
    while (length > 0 && (text[length - 1] == std::byte{0} || text[length - 1] == std::byte{' '}))
        --length;
    const std::string_view word(reinterpret_cast<const char*>(text), length);
    return word.find_first_not_of("0123456789.\\") == std::string_view::npos;
}

class Walk {
  public:
    /// @param found  gets irregularities that do not end the check
    Walk(Source& source, bool bigEndian, bool implicit, std::string& found)
        : source_(source), bigEndian_(bigEndian), implicit_(implicit), found_(found) {}

    Element head(std::uint64_t at) {
        Element e;
        ++source_.heads;
        e.tag = number(at, 2) << 16 | number(at + 2, 2);
        const bool isItem = e.tag >> 16 == 0xFFFE;
        if (implicit_ || isItem) {
            e.length = number(at + 4, 4);
            e.content = at + 8;
            // An implicit element of undefined length is a sequence.
            e.isSequence = !isItem && e.length == kUndefined && e.tag != kPixelTag;
            return e;
        }
        const std::byte* vr = source_.at(at + 4, 2);
        const std::string_view word(reinterpret_cast<const char*>(vr), 2);
        const auto known = std::find_if(kRepresentations.begin(), kRepresentations.end(),
                                        [&](const Representation& r) { return r.name == word; });
        if (known == kRepresentations.end())
            throw Irregular{"an unknown value representation at " + tagText(e.tag)};
        e.length = known->isLong ? number(at + 8, 4) : number(at + 6, 2);
        e.content = at + (known->isLong ? 12 : 8);
        if (known->isLong && number(at + 6, 2) != 0)
            note("reserved bytes that are not zero", e);
        e.isUnknown = known->name == "UN";
        e.isUid = known->name == "UI";
        e.isSequence = known->name == "SQ" || (e.length == kUndefined && e.tag != kPixelTag);
        if (e.length != kUndefined && e.length % known->valueBytes != 0)
            note("a length that does not suit " + std::string(known->name), e);
        return e;
    }

    /// Elements from `at` on, ascending, to `end` or until one has the tag `until`; returns where it stopped.
    std::uint64_t elements(std::uint64_t at, std::uint64_t end, std::uint32_t until, int depth) {
        std::uint64_t before = 0; // one more than a tag; 0: none yet
        while (at < end) {
            const Element e = head(at);
            if (e.tag == until)
                return at;
            if (std::uint64_t{e.tag} + 1 <= before)
                note("elements out of order", e);
            before = std::uint64_t{e.tag} + 1;
            at = after(e, end, depth);
        }
        if (at != end)
            throw Irregular{"an element that goes beyond what holds it"};
        return at;
    }

    /// The start of the next element.
    std::uint64_t after(const Element& e, std::uint64_t end, int depth) {
        if (e.length == kUndefined && !e.isSequence)
            throw Irregular{"an undefined length at " + tagText(e.tag)};
        if (e.length != kUndefined && e.length > end - std::min(end, e.content))
            throw Irregular{"a length beyond what holds it at " + tagText(e.tag), end == source_.size()};
        if (e.length != kUndefined && e.length % 2 != 0)
            note("an odd length", e);
        if (e.isUid && e.length <= kMostUidBytes && !isUids(source_.at(e.content, e.length), e.length))
            note("text that is no UID", e);
        if (e.isSequence && e.isUnknown) // PS3.5, 6.2.2, note on UN of undefined length
            return Walk(source_, false, true, found_).items(e, end, depth + 1);
        if (e.isSequence)
            return items(e, end, depth + 1);
        return e.content + e.length;
    }

    std::uint32_t number(std::uint64_t at, std::size_t bytes) {
        const std::byte* from = source_.at(at, bytes);
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < bytes; ++i)
            value = value << 8 | std::to_integer<std::uint32_t>(from[bigEndian_ ? i : bytes - 1 - i]);
        return value;
    }

    void note(const std::string& words, const Element& e) {
        if (found_.empty())
            found_ = words + " at " + tagText(e.tag);
    }

  private:
    std::uint64_t items(const Element& sequence, std::uint64_t end, int depth) {
        if (depth > kMostNested)
            throw Irregular{"more than 16 sequences in one another"};
        const bool open = sequence.length == kUndefined;
        std::uint64_t at = sequence.content;
        const std::uint64_t last = open ? end : at + sequence.length;
        while (at < last) {
            const Element item = head(at);
            if (open && item.tag == kSequenceEnd)
                return item.content;
            if (item.tag != kItem)
                throw Irregular{"something other than an item in " + tagText(sequence.tag)};
            if (item.length == kUndefined) {
                at = elements(item.content, last, kItemEnd, depth);
                at = head(at).content;
            } else {
                if (item.length > last - std::min(last, item.content))
                    throw Irregular{"an item that goes beyond " + tagText(sequence.tag)};
                at = elements(item.content, item.content + item.length, kItemEnd, depth);
            }
        }
        if (open || at != last)
            throw Irregular{"a sequence without its end at " + tagText(sequence.tag)};
        return at;
    }

    Source& source_;
    bool bigEndian_, implicit_;
    std::string& found_;
};

/// Skips the items of encapsulated pixels, which framesOf() has checked.
std::uint64_t afterFragments(Walk& walk, std::uint64_t at) {
    while (true) {
        const Element item = walk.head(at);
        if (item.tag == kSequenceEnd)
            return item.content;
        if (item.tag != kItem || item.length == kUndefined)
            throw Irregular{"something other than fragments in the pixels"};
        at = item.content + item.length;
    }
}

bool isFilling(Source& source, std::uint64_t at) {
    if (source.size() % kBlockBytes != 0 || source.size() - at >= 64 * kBlockBytes)
        return false;
    const std::byte* rest = source.at(at, static_cast<std::size_t>(source.size() - at));
    return std::all_of(rest, rest + (source.size() - at), [](std::byte b) { return b == std::byte{0}; });
}

/// True if the element at `at` has a known representation.
bool looksExplicit(Source& source, std::uint64_t at) {
    const std::byte* vr = source.at(at + 4, 2);
    const std::string_view word(reinterpret_cast<const char*>(vr), 2);
    return std::any_of(kRepresentations.begin(), kRepresentations.end(),
                       [&](const Representation& r) { return r.name == word; });
}

/// The meta group, always explicit and little endian. Returns where the data set begins.
std::uint64_t walkMeta(Source& source, std::uint64_t begin, DicomStructure& out) {
    Walk meta(source, false, false, out.irregularity);
    const Element length = meta.head(begin);
    if (length.tag != 0x00020000 || length.length != 4)
        throw Irregular{"no length of the meta group"};
    const std::uint64_t dataSet = length.content + 4 + meta.number(length.content, 4);
    if (dataSet > source.size())
        throw Irregular{"a meta group that goes beyond the end of the file", true};
    const std::uint64_t at = meta.elements(begin, dataSet, kSyntaxTag, 0);
    if (at == dataSet)
        throw Irregular{"no transfer syntax"};
    const Element syntax = meta.head(at);
    if (syntax.length == 0 || syntax.length > 64)
        throw Irregular{"a transfer syntax of " + std::to_string(syntax.length) + " bytes"};
    out.syntax.assign(reinterpret_cast<const char*>(source.at(syntax.content, syntax.length)), syntax.length);
    while (!out.syntax.empty() && (out.syntax.back() == '\0' || out.syntax.back() == ' '))
        out.syntax.pop_back();
    meta.elements(at, dataSet, 0, 0);
    return dataSet;
}

/// The pixels of a data set and what follows them.
void walkPixels(Source& source, Walk& walk, std::uint64_t at, DicomStructure& out) {
    const Element pixels = walk.head(at);
    out.pixelOffsetBytes = pixels.content;
    const std::uint64_t rest =
        pixels.length == kUndefined ? afterFragments(walk, pixels.content) : pixels.content + pixels.length;
    if (rest > source.size()) // a parser stops before the pixels
        throw Irregular{"pixels that go beyond the end of the file"};
    if (rest == source.size() || isFilling(source, rest))
        return;
    if (walk.head(rest).tag <= kPixelTag)
        throw Irregular{"elements out of order behind the pixels"};
    walk.elements(rest, source.size(), 0, 0);
}

void walkAll(Source& source, DicomStructure& out) {
    const bool marked = source.size() >= kMarkEnd && std::memcmp(source.at(128, 4), "DICM", 4) == 0;
    std::uint64_t dataSet = marked ? kMarkEnd : 0;
    if (marked || std::to_integer<int>(*source.at(0, 1)) == 2) // group 0002
        dataSet = walkMeta(source, dataSet, out);
    if (out.syntax == kDeflated)
        return;
    const bool implicit =
        out.syntax.empty() ? !looksExplicit(source, dataSet) : out.syntax == kImplicitSyntax;
    Walk walk(source, out.syntax == kBigEndianSyntax, implicit, out.irregularity);
    const std::uint64_t pixels = walk.elements(dataSet, source.size(), kPixelTag, 0);
    if (pixels < source.size())
        walkPixels(source, walk, pixels, out);
}

} // namespace

DicomStructure structureOf(const std::filesystem::path& path) {
    const InputFile file(path);
    Source source(file.sizeBytes(),
                  [&](std::uint64_t offset, std::span<std::byte> out) { return file.readSome(offset, out); });
    DicomStructure out;
    try {
        walkAll(source, out);
        out.elements = source.heads;
    } catch (const Irregular& irregular) {
        if (out.irregularity.empty() || irregular.breaksOff)
            out.irregularity = irregular.words;
        out.breaksOff = irregular.breaksOff;
    }
    return out;
}

} // namespace tessera
