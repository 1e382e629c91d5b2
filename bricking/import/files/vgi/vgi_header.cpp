// bricking/import/files/vgi/vgi_header.cpp: see vgi_header.h. The format has no public specification: the
// rules are those of headers that VGSTUDIO, phoenix datos|x, CERA and aRTist write.
#include "bricking/import/files/vgi/vgi_header.h"

#include "bricking/import/files/header_words.h"
#include "bricking/import/source/plausible.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr std::size_t kAxes = 3;

/// "[file1]" of "{volume1}": values by their keys in lower case.
using Section = std::map<std::string, std::string>;
/// "{volume1}": its sections by their names in lower case.
using Object = std::map<std::string, Section>;

/// "volume12" of "volume".
bool isNumbered(std::string_view name, std::string_view kind) {
    return name.starts_with(kind) && name.size() > kind.size() &&
           name.find_first_not_of("0123456789", kind.size()) == std::string_view::npos;
}

/// The name between brackets of a whole line; nullopt: it is another line.
std::optional<std::string> bracketed(std::string_view line, char open, char close) {
    if (line.size() < 3 || line.front() != open || line.back() != close)
        return std::nullopt;
    return lowered(withoutBlanks(line.substr(1, line.size() - 2)));
}

double millimetresOf(const std::string& unit) {
    static const std::map<std::string, double> units = {{"mm", 1},    {"cm", 10},   {"m", 1000},
                                                        {"um", 1e-3}, {"nm", 1e-6}, {"inch", 25.4}};
    const auto at = units.find(lowered(unit));
    return at == units.end() ? 0 : at->second;
}

/// Of the file of voxels.
constexpr std::array kFileKeys = {"size",       "datatype",   "datarange",
                                  "mirror",     "skipheader", "bitsperelement",
                                  "fileformat", "name",       "regionofintereststart",
                                  "byteorder",  "endian",     "regionofinterestend",
                                  "endianness"};

bool isRead(const std::string& key) {
    return key == "resolution" || key == "unit" || key == "scale" || key == "rotate" || key == "volume" ||
           std::ranges::find(kFileKeys, key) != kFileKeys.end();
}

class VgiReader {
  public:
    VgiReader(std::filesystem::path path, const std::optional<glm::dvec3>& spacingMm)
        : path_(std::move(path)), where_(path_.string()), spacingMm_(spacingMm) {}

    VgiHeader read() {
        takeLines();
        const std::string volume = onlyOf(objects_, "volume", "one volume");
        const Object& sections = objects_.at(volume);
        file_ = onlyOf(sections, "file", "one file of voxels");
        voxels_ = &sections.at(file_);
        if (const auto at = sections.find("representation"); at != sections.end())
            held_ = &at->second;
        readVoxels();
        readRegion();
        readName();
        readPlace(volume);
        passOver();
        header_.info.validate(where_);
        return std::move(header_);
    }

  private:
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(where_, expected, found);
    }

    void takeLines() {
        const InputFile file(path_);
        HeaderLines lines(file, "Volume Graphics");
        Object* object = nullptr;
        Section* section = nullptr;
        std::string last; // key
        while (const std::optional<std::string> next = lines.next()) {
            const std::string_view line = withoutBlanks(*next);
            if (line.empty())
                continue;
            if (const auto name = bracketed(line, '{', '}')) {
                object = &objects_[*name];
                section = nullptr;
            } else if (const auto part = bracketed(line, '[', ']'); part && object) {
                section = &(*object)[*part];
            } else {
                const std::size_t at = line.find('=');
                if (!object)
                    refuse("a Volume Graphics header, which begins with {volume1}", shownWord(line));
                if (!section || at == std::string_view::npos)
                    continue; // of the scene, which is not read
                const auto [row, isNew] = section->emplace(lowered(withoutBlanks(line.substr(0, at))),
                                                           withoutBlanks(line.substr(at + 1)));
                if (!isNew && row->second != withoutBlanks(line.substr(at + 1)))
                    repeated_.emplace(section, row->first);
                last = row->first;
            }
        }
        char end = '\n';
        if (file.sizeBytes() > 0)
            file.readAt(file.sizeBytes() - 1, std::as_writable_bytes(std::span(&end, 1)));
        // Texts may end so; what is read here may have lost its last digits.
        if (end != '\n' && isRead(last))
            refuse("a whole line of " + shownWord(last), "the end of the file (is it truncated?)");
    }

    /// The name of the only entry of a kind that has a number.
    template <typename Map>
    std::string onlyOf(const Map& entries, const char* kind, const char* expected) const {
        std::string only, all;
        for (const auto& [name, entry] : entries)
            if (isNumbered(name, kind)) {
                all += (all.empty() ? "" : ", ") + shownWord(name);
                only = only.empty() ? name : only;
            }
        if (all.empty())
            refuse(std::string(expected) + " (\"" + kind + "1\")", "none (is it truncated?)");
        if (all != shownWord(only))
            refuse(expected, "several: " + all);
        return only;
    }

    /// Of the file, else of the whole volume. Null: neither says it.
    const std::string* field(const std::string& key) const {
        for (const Section* const section : {voxels_, held_})
            if (section && section->contains(key)) {
                requireOnce(*section, key);
                return &section->at(key);
            }
        return nullptr;
    }
    void requireOnce(const Section& section, const std::string& key) const {
        if (repeated_.contains({&section, key}))
            refuse("every key once", "\"" + key + "\" again, with another value");
    }
    const std::string& required(const std::string& key) const {
        if (const std::string* value = field(key))
            return *value;
        refuse("\"" + key + "\" in [" + file_ + "]", "none (is it truncated?)");
    }
    std::vector<double> numbers(const std::string& key, const std::string& text, std::size_t least,
                                std::size_t most) const {
        std::vector<double> out;
        for (const std::string& word : wordsOf(text)) {
            const std::optional<double> number = realNumberOf(word);
            if (!number || !std::isfinite(*number))
                refuse("\"" + key + "\" of finite numbers", shownWord(text));
            out.push_back(*number);
        }
        if (out.size() < least || out.size() > most)
            refuse("\"" + key + "\" of " + std::to_string(least) + " numbers", shownWord(text));
        return out;
    }
    std::array<std::int64_t, kAxes> wholes(const std::string& key, const std::string& text) const {
        std::array<std::int64_t, kAxes> out{};
        const std::vector<double> given = numbers(key, text, kAxes, kAxes);
        for (std::size_t axis = 0; axis < kAxes; ++axis) {
            if (given[axis] != std::floor(given[axis]) || given[axis] < 0 ||
                given[axis] > std::numeric_limits<std::int32_t>::max())
                refuse("\"" + key + "\" of whole numbers below 2^31", shownWord(text));
            out[axis] = static_cast<std::int64_t>(given[axis]);
        }
        return out;
    }

    void readVoxels() {
        DataFiles& files = header_.files;
        std::uint64_t values = 1;
        for (const std::int64_t size : wholes("size", required("size"))) {
            constexpr std::uint64_t kMostValues = std::uint64_t{1} << 58;
            if (size < 1 || values > kMostValues / static_cast<std::uint64_t>(size))
                refuse("\"size\" of whole numbers of at least 1, and 2^58 values at most",
                       shownWord(required("size")));
            values *= static_cast<std::uint64_t>(size);
            header_.info.extentVoxels[static_cast<int>(files.sizes.size())] = static_cast<int>(size);
            files.sizes.push_back(size);
        }
        if (const std::string* format = field("fileformat"); format && lowered(*format) != "raw")
            refuse("voxels that are not packed (FileFormat = raw)", shownWord(*format));
        for (const char* const key : {"byteorder", "endian", "endianness"})
            if (const std::string* order = field(key); order && !lowered(*order).starts_with("little"))
                refuse("numbers in little endian order", shownWord(*order));
        struct Row {
            const char *words, *bits;
            FileType type;
        };
        static constexpr std::array kTypes = {Row{"unsigned integer", "8", FileType::u8},
                                              Row{"unsigned integer", "16", FileType::u16},
                                              Row{"unsigned integer", "32", FileType::u32},
                                              Row{"signed integer", "8", FileType::i8},
                                              Row{"signed integer", "16", FileType::i16},
                                              Row{"signed integer", "32", FileType::i32},
                                              Row{"float", "32", FileType::f32},
                                              Row{"float", "64", FileType::f64}};
        const std::string words = lowered(required("datatype")), bits = required("bitsperelement");
        const auto* const row = std::ranges::find_if(
            kTypes, [&](const Row& each) { return each.words == words && each.bits == bits; });
        if (row == kTypes.end())
            refuse("an \"unsigned integer\" or \"signed integer\" of 8, 16 or 32 bits, or a \"float\" of 32 "
                   "or 64",
                   shownWord(words) + " of " + shownWord(bits) + " bits");
        files.type = row->type;
        header_.info.type = storedTypeOf(files.type);
        if (const std::string* skipped = field("skipheader")) {
            const std::optional<std::int64_t> bytes = wholeNumberOf(*skipped);
            if (!bytes || *bytes < 0 || *bytes > std::int64_t{1} << 53)
                refuse("\"SkipHeader\" as a whole number of bytes", shownWord(*skipped));
            files.byteSkip = *bytes;
        }
    }

    /// The volume is the whole file.
    void readRegion() const {
        const auto whole = [&](const Section* section, const char* key, std::int64_t first, bool isLast) {
            if (!section || !section->contains(key))
                return;
            requireOnce(*section, key);
            const std::string& text = section->at(key);
            const auto given = wholes(key, text);
            for (std::size_t axis = 0; axis < kAxes; ++axis)
                if (given[axis] != first + (isLast ? header_.files.sizes[axis] : 0))
                    refuse("a volume that is the whole file of " + required("size") + " voxels",
                           "\"" + std::string(key) + "\" " + shownWord(text));
        };
        whole(voxels_, "regionofintereststart", 0, false);
        whole(voxels_, "regionofinterestend", -1, true);
        whole(held_, "size", 0, true);
    }

    void readName() {
        std::string name = required("name");
        const bool isWindows = name.size() > 2 && name[1] == ':';
        std::ranges::replace(name, '\\', '/');
        if (name.empty() || name.ends_with('/'))
            refuse("\"Name\" of the file of voxels", shownWord(required("name")));
        std::filesystem::path data = name;
        // Of another machine: it lies beside the header.
        if (isWindows || data.is_absolute())
            data = data.filename();
        for (const auto& part : data)
            if (part == "..")
                refuse("\"Name\" of a file below the header's folder", shownWord(name));
        header_.files.dataFiles = {path_.parent_path() / data};
    }

    /// 1: reversed. Of the whole volume a fourth number may follow, whose meaning is not known.
    std::array<bool, kAxes> mirrored() const {
        std::array<bool, kAxes> out{};
        for (const Section* const section : {voxels_, held_}) {
            if (!section || !section->contains("mirror"))
                continue;
            requireOnce(*section, "mirror");
            const std::string& text = section->at("mirror");
            const std::vector<double> given = numbers("mirror", text, kAxes, kAxes + 1);
            for (std::size_t axis = 0; axis < given.size(); ++axis) {
                if (given[axis] != 0 && (given[axis] != 1 || axis == kAxes || section == held_))
                    refuse("\"Mirror\" of three numbers 0 or 1, of the file alone", shownWord(text));
                if (axis < kAxes)
                    out[axis] = out[axis] || given[axis] == 1;
            }
        }
        return out;
    }

    /// The geometry of the objects that show the volume; it must be the same in all.
    const Section* geometryOf(const std::string& volume) const {
        const Section* found = nullptr;
        for (const auto& [name, object] : objects_) {
            if (!isNumbered(name, "volumeprimitive") || !object.contains("geometry"))
                continue;
            const auto shown = object.find("volume");
            if (shown != object.end() && shown->second.contains("volume") &&
                lowered(shown->second.at("volume")) != volume)
                continue;
            const Section& geometry = object.at("geometry");
            for (const char* const key : {"resolution", "unit", "scale"}) {
                requireOnce(geometry, key);
                const auto valueIn = [&](const Section& of) {
                    return of.contains(key) ? of.at(key) : std::string();
                };
                if (found && valueIn(*found) != valueIn(geometry))
                    refuse("one \"" + std::string(key) + "\" of the volume",
                           shownWord(valueIn(*found)) + " and " + shownWord(valueIn(geometry)));
            }
            found = &geometry;
        }
        return found;
    }

    void readPlace(const std::string& volume) {
        VolumeInfo& info = header_.info;
        const Section* const geometry = geometryOf(volume);
        const auto word = [&](const char* key) {
            return geometry && geometry->contains(key) ? geometry->at(key) : std::string();
        };
        if (!word("scale").empty() &&
            numbers("scale", word("scale"), kAxes, kAxes) != std::vector<double>(kAxes, 1))
            refuse("a volume that its scene does not scale (scale = 1 1 1)", shownWord(word("scale")));
        if (!word("rotate").empty() && wordsOf(word("rotate")) != wordsOf("1 0 0 0 1 0 0 0 1"))
            info.remarks.emplace_back("the volume is turned in its scene (rotate), which is left out");
        const std::string resolution = word("resolution"), unit = word("unit");
        const double mm = millimetresOf(unit);
        if (!unit.empty() && mm == 0)
            refuse("\"unit\" nm, um, mm, cm, m or inch", shownWord(unit));
        glm::dvec3 spacing = spacingMm_.value_or(glm::dvec3(1));
        header_.saysSpacing = !resolution.empty() && mm > 0;
        if (!resolution.empty()) {
            const std::vector<double> given = numbers("resolution", resolution, kAxes, kAxes);
            if (std::ranges::any_of(given, [](double length) { return !(length > 0); }))
                refuse("\"resolution\" above 0", shownWord(resolution));
            if (header_.saysSpacing)
                spacing = mm * glm::dvec3(given[0], given[1], given[2]);
        }
        const std::array<bool, kAxes> isReversed = mirrored();
        glm::dvec3 origin(0), step = spacing;
        for (int axis = 0; axis < static_cast<int>(kAxes); ++axis)
            if (isReversed[static_cast<std::size_t>(axis)]) {
                origin[axis] = (info.extentVoxels[axis] - 1) * spacing[axis];
                step[axis] = -spacing[axis];
            }
        info.patientFromVoxel = patientFromVoxelOf(origin, {step.x, 0, 0}, {0, step.y, 0}, {0, 0, step.z});
        info.orientationKnown = false;
        requirePlausibleGeometry(info, {"\"resolution\"", "\"resolution\"", "\"resolution\""}, where_);
    }

    /// Keys of the voxels whose meaning is not known. A remark has plain code words alone.
    void passOver() {
        std::string others;
        const auto isCodeWord = [](const std::string& key) {
            constexpr std::size_t kLongest = 32;
            return key.size() <= kLongest &&
                   key.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
        };
        for (const auto& [key, value] : *voxels_)
            if (std::ranges::find(kFileKeys, key) == kFileKeys.end())
                others += (others.empty() ? "" : ", ") + (isCodeWord(key) ? shownWord(key) : "another");
        if (!others.empty())
            header_.info.remarks.push_back("keys of the file of voxels that are passed over: " + others);
    }

    std::filesystem::path path_;
    std::string where_;
    std::optional<glm::dvec3> spacingMm_;
    std::map<std::string, Object> objects_;                     // by their names in lower case
    std::set<std::pair<const Section*, std::string>> repeated_; // keys with several values
    std::string file_;                                          // "file1"
    const Section *voxels_ = nullptr, *held_ = nullptr;         // of the file; of the whole volume
    VgiHeader header_;
};

} // namespace

VgiHeader readVgiHeader(const std::filesystem::path& path, const std::optional<glm::dvec3>& spacingMm) {
    return VgiReader(path, spacingMm).read();
}

} // namespace tessera
