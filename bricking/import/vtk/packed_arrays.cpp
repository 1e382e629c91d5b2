// bricking/import/vtk/packed_arrays.cpp: see packed_arrays.h.
#include "bricking/import/vtk/packed_arrays.h"

#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {
namespace {

constexpr std::size_t kLongestElement = 4096, kWindow = std::size_t{1} << 20;

std::string textAt(const InputFile& file, std::uint64_t at, std::size_t most) {
    std::string text(most, '\0');
    text.resize(at < file.sizeBytes() ? file.readSome(at, std::as_writable_bytes(std::span(text))) : 0);
    return text;
}

/// Of an element's attribute; empty: it has none.
std::string attributeOf(std::string_view element, const std::string& name) {
    for (const char quote : {'"', '\''}) {
        const std::string start = " " + name + "=" + quote;
        if (const std::size_t at = element.find(start); at != std::string_view::npos) {
            const std::size_t from = at + start.size(), to = element.find(quote, from);
            return std::string(element.substr(from, to == std::string_view::npos ? to : to - from));
        }
    }
    return {};
}

std::string fromBase64(std::string_view text) {
    std::string bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                          : c >= 'a' && c <= 'z' ? c - 'a' + 26
                          : c >= '0' && c <= '9' ? c - '0' + 52
                          : c == '+'             ? 62
                          : c == '/'             ? 63
                                                 : -1;
        if (value < 0)
            break;
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        count += 6;
        if (count >= 8) {
            count -= 8;
            bytes += static_cast<char>(bits >> count & 255u);
        }
    }
    return bytes;
}

class PackedWalk {
  public:
    PackedWalk(const InputFile& file, std::uint64_t mostBytes)
        : file_(file), where_(file.path().string()), mostBytes_(mostBytes) {
        const std::string head = textAt(file, 0, kLongestElement);
        const std::size_t at = head.find("<VTKFile");
        const std::string first = at == std::string::npos ? "" : head.substr(at, head.find('>', at) - at);
        longWords_ = attributeOf(first, "header_type") == "UInt64";
        bigEndian_ = attributeOf(first, "byte_order") == "BigEndian";
    }

    void walk() {
        std::vector<std::uint64_t> offsets;
        for (std::uint64_t at = 0; at < file_.sizeBytes();) {
            const std::string window = textAt(file_, at, kWindow + kLongestElement);
            const std::size_t found = std::min(window.find("<DataArray"), window.find("<AppendedData"));
            if (found == std::string::npos || found >= kWindow) {
                at += kWindow;
                continue;
            }
            const std::size_t end = window.find('>', found);
            if (end == std::string::npos || end - found > kLongestElement - 128)
                throw badFile(where_, "elements of less than 4096 characters", "a longer one");
            const std::string_view element = std::string_view(window).substr(found, end - found);
            const std::uint64_t behind = at + end + 1;
            if (element.starts_with("<AppendedData")) {
                walkAppended(behind, attributeOf(element, "encoding") != "raw", offsets);
                return;
            }
            const std::string format = attributeOf(element, "format");
            if (format == "appended")
                offsets.push_back(std::strtoull(attributeOf(element, "offset").c_str(), nullptr, 10));
            else if (format == "binary") {
                const std::string text = textAt(file_, behind, kLongestElement);
                const std::size_t start = text.find_first_not_of(" \t\r\n");
                if (start != std::string::npos)
                    check(fromBase64(std::string_view(text).substr(start, 64)));
            }
            at = behind;
        }
    }

  private:
    void walkAppended(std::uint64_t at, bool isText, const std::vector<std::uint64_t>& offsets) const {
        const std::string text = textAt(file_, at, kLongestElement);
        const std::size_t mark = text.find('_');
        if (mark == std::string::npos)
            throw badFile(where_, "\"_\" before appended values", "none");
        for (const std::uint64_t offset : offsets) {
            const std::uint64_t from = at + mark + 1 + offset;
            const std::string head = from >= offset ? textAt(file_, from, 64) : std::string();
            check(isText ? fromBase64(head) : head);
        }
    }

    void check(const std::string& bytes) const {
        std::array<std::uint64_t, 3> words{}; // blocks, bytes of one, of the last if it is shorter
        const std::size_t wordBytes = longWords_ ? 8 : 4;
        if (bytes.size() < 3 * wordBytes)
            throw badFile(where_, "the sizes of packed blocks", "the end of the file (is it truncated?)");
        for (std::size_t n = 0; n < 3; ++n)
            for (std::size_t i = 0; i < wordBytes; ++i) {
                const std::size_t at = n * wordBytes + (bigEndian_ ? i : wordBytes - 1 - i);
                words[n] = words[n] << 8 | static_cast<unsigned char>(bytes[at]);
            }
        const auto [blocks, size, last] = words;
        if (blocks == 0)
            return;
        if (size == 0 || size > mostBytes_ || last > size || blocks > file_.sizeBytes() / wordBytes ||
            blocks > mostBytes_ / size + 1)
            throw badFile(where_,
                          "packed blocks of an array of at most " + std::to_string(mostBytes_) + " bytes",
                          std::to_string(blocks) + " of " + std::to_string(size) +
                              " bytes, the last one of " + std::to_string(last));
    }

    const InputFile& file_;
    std::string where_;
    std::uint64_t mostBytes_;
    bool longWords_ = false, bigEndian_ = false;
};

} // namespace

bool isPackedVtk(const InputFile& file) {
    const std::string head = textAt(file, 0, kLongestElement);
    return head.substr(0, head.find("<ImageData")).find("compressor=") != std::string::npos;
}

void checkPackedVtk(const InputFile& file, std::uint64_t mostBytes) {
    PackedWalk(file, mostBytes).walk();
}

} // namespace tessera
