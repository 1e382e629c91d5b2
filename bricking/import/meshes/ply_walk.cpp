// bricking/import/meshes/ply_walk.cpp: a walk over PLY, text and binary: see mesh_walk.h. Source: Turk, "The
// PLY Polygon File Format".
#include "bricking/import/meshes/mesh_walk.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <limits>

namespace tessera {
namespace {

constexpr std::size_t kMostOfPlyLine = 4000; // bytes; VTK has 4096 for one
constexpr std::size_t kMostHeaderLines = 1000;
constexpr std::uint64_t kMostCorners = 255; // of a face

struct PlyType {
    const char *name, *otherName;
    std::size_t bytes;
    bool isSigned, isFloat;
};
constexpr std::array<PlyType, 8> kPlyTypes{{{"char", "int8", 1, true, false},
                                            {"uchar", "uint8", 1, false, false},
                                            {"short", "int16", 2, true, false},
                                            {"ushort", "uint16", 2, false, false},
                                            {"int", "int32", 4, true, false},
                                            {"uint", "uint32", 4, false, false},
                                            {"float", "float32", 4, true, true},
                                            {"double", "float64", 8, true, true}}};

struct PlyProperty {
    std::string name;
    const PlyType* type = nullptr;
    const PlyType* countType = nullptr; // of a list
};
struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
};
enum class PlyCoding { text, little, big };

class PlyWalk {
  public:
    explicit PlyWalk(const InputFile& file) : file_(file), walk_(file) {}

    MeshCounts counts() {
        readHeader();
        for (const PlyElement& element : elements_)
            checkSize(element);
        MeshCounts counts{elements_[0].count, 0, true};
        for (std::uint64_t n = 0; n < elements_[0].count; ++n)
            passItem(elements_[0], counts);
        for (std::uint64_t n = 0; hasFaces_ && n < elements_[1].count; ++n)
            passItem(elements_[1], counts);
        return counts;
    }

  private:
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(file_.path().string(), expected, found);
    }
    std::string quoted(std::string_view text) const {
        return "\"" + printable(std::string(text.substr(0, 60))) + "\"";
    }
    const PlyType* typeNamed(std::string_view name) const {
        const auto found = std::find_if(kPlyTypes.begin(), kPlyTypes.end(), [&](const PlyType& t) {
            return name == t.name || name == t.otherName;
        });
        if (found == kPlyTypes.end())
            refuse("a type of PLY", quoted(name));
        return &*found;
    }

    void readHeader() {
        for (std::size_t number = 0;; ++number) {
            const auto line = walk_.line(kMostOfPlyLine);
            if (!line)
                refuse("end_header", "the end of the file");
            if (number > kMostHeaderLines)
                refuse("a header of at most " + std::to_string(kMostHeaderLines) + " lines", "a longer one");
            const std::vector<std::string_view> words = wordsOf(*line);
            if (number == 0) {
                if (words.size() != 1 || words[0] != "ply")
                    refuse("a file that begins with \"ply\"", quoted(*line));
                continue;
            }
            if (words.empty() || words[0] == "comment" || words[0] == "obj_info")
                continue;
            if (words[0] == "end_header")
                break;
            if (words[0] == "format" && words.size() == 3)
                coding_ = words[1] == "ascii"                  ? PlyCoding::text
                          : words[1] == "binary_little_endian" ? PlyCoding::little
                          : words[1] == "binary_big_endian"
                              ? PlyCoding::big
                              : (refuse("a format of PLY", quoted(*line)), PlyCoding::text);
            else if (words[0] == "element" && words.size() == 3)
                addElement(words);
            else if (words[0] == "property" && !elements_.empty() && (words.size() == 3 || words.size() == 5))
                addProperty(words);
            else
                refuse("a header of PLY", quoted(*line));
        }
        hasFaces_ = elements_.size() > 1;
        if (elements_.empty() || elements_[0].name != "vertex" || (hasFaces_ && elements_[1].name != "face"))
            refuse("elements vertex and face, in this order", "others");
        for (const char* axis : {"x", "y", "z"})
            if (std::none_of(elements_[0].properties.begin(), elements_[0].properties.end(),
                             [&](const PlyProperty& p) { return p.name == axis && !p.countType; }))
                refuse("vertices with x, y and z", std::string("no ") + axis);
        if (hasFaces_ &&
            std::none_of(elements_[1].properties.begin(), elements_[1].properties.end(), isCorners))
            refuse("faces with a list vertex_indices", "none");
    }
    void addElement(const std::vector<std::string_view>& words) {
        PlyElement element{std::string(words[1]), 0, {}};
        const auto read = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
        if (read.ec != std::errc() || read.ptr != words[2].data() + words[2].size())
            refuse("a number of elements", quoted(words[2]));
        elements_.push_back(std::move(element));
    }
    void addProperty(const std::vector<std::string_view>& words) {
        PlyProperty property{std::string(words.back()), typeNamed(words[words.size() - 2]), nullptr};
        if (words.size() == 5) {
            property.countType = typeNamed(words[2]);
            if (words[1] != "list" || property.countType->isFloat)
                refuse("property list of a whole number", quoted(words[1]));
        }
        elements_.back().properties.push_back(std::move(property));
    }
    static bool isCorners(const PlyProperty& p) {
        return p.countType && !p.type->isFloat && (p.name == "vertex_indices" || p.name == "vertex_index");
    }

    /// An element's fewest bytes, of the file's rest.
    void checkSize(const PlyElement& element) const {
        std::uint64_t fewest = 0; // of text a digit and what parts it from the next
        for (const PlyProperty& p : element.properties)
            fewest += coding_ == PlyCoding::text ? 2
                      : !p.countType             ? p.type->bytes
                      : isCorners(p)             ? p.countType->bytes + 3 * p.type->bytes
                                                 : p.countType->bytes;
        if (element.properties.empty() ||
            element.count > (walk_.left() + 1) / std::max<std::uint64_t>(fewest, 1))
            refuse(std::to_string(element.count) + " of element " + element.name + ", as its header tells",
                   std::to_string(walk_.left()) + " bytes behind the header");
    }

    void passItem(const PlyElement& element, MeshCounts& counts) {
        if (coding_ == PlyCoding::text) {
            const auto line = walk_.line(kMostOfPlyLine);
            if (!line)
                refuse(std::to_string(element.count) + " of element " + element.name, "the end of the file");
            words_ = wordsOf(*line);
            next_ = 0;
        }
        for (const PlyProperty& p : element.properties) {
            std::uint64_t items = 1;
            if (p.countType) {
                const std::int64_t count = whole(*p.countType);
                if (count < 0 || (isCorners(p) && count < 3) ||
                    static_cast<std::uint64_t>(count) > kMostCorners)
                    refuse(isCorners(p) ? "faces of 3 to 255 corners" : "lists of at most 255 items",
                           std::to_string(count));
                items = static_cast<std::uint64_t>(count);
                if (isCorners(p))
                    counts.triangles += items - 2;
            }
            for (std::uint64_t n = 0; n < items; ++n) {
                if (!isCorners(p)) {
                    pass(*p.type);
                    continue;
                }
                const std::int64_t corner = whole(*p.type);
                if (corner < 0 || static_cast<std::uint64_t>(corner) >= counts.points)
                    refuse("numbers of vertices below " + std::to_string(counts.points),
                           std::to_string(corner));
            }
        }
        if (coding_ == PlyCoding::text && next_ != words_.size())
            refuse("lines of element " + element.name + " with " + std::to_string(next_) + " numbers",
                   "one with " + std::to_string(words_.size()));
    }
    std::string_view word() {
        if (next_ == words_.size())
            refuse("another number in a line", "its end");
        return words_[next_++];
    }
    void pass(const PlyType& type) {
        if (coding_ == PlyCoding::text) {
            word();
            return;
        }
        std::array<char, 8> bytes{};
        walk_.take(bytes.data(), type.bytes);
    }
    std::int64_t whole(const PlyType& type) {
        std::int64_t value = 0;
        if (coding_ == PlyCoding::text) {
            const std::string_view text = word();
            const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
            if (read.ec != std::errc() || read.ptr != text.data() + text.size())
                refuse("a whole number", quoted(text));
            return value;
        }
        std::array<unsigned char, 8> bytes{};
        walk_.take(bytes.data(), type.bytes);
        std::uint64_t bits = 0;
        for (std::size_t n = 0; n < type.bytes; ++n)
            bits |= static_cast<std::uint64_t>(bytes[n])
                    << (8 * (coding_ == PlyCoding::little ? n : type.bytes - 1 - n));
        if (type.bytes == 0 || type.bytes > bytes.size())
            return 0; // no type is
        const std::size_t unused = 64 - 8 * type.bytes;
        return type.isSigned ? static_cast<std::int64_t>(bits << unused) >> unused
                             : static_cast<std::int64_t>(bits);
    }

    const InputFile& file_;
    FileWalk walk_;
    PlyCoding coding_ = PlyCoding::text;
    bool hasFaces_ = false; // else it holds points alone
    std::vector<PlyElement> elements_;
    std::vector<std::string_view> words_;
    std::size_t next_ = 0;
};

} // namespace

MeshCounts walkPly(const InputFile& file) {
    return PlyWalk(file).counts();
}

} // namespace tessera
