// bricking/import/files/metaimage/meta_header.cpp: see meta_header.h. Rules: MetaIO's documentation; where it
// is silent, what ITK's reader does.
#include "bricking/import/files/metaimage/meta_header.h"

#include "bricking/import/files/header_words.h"
#include "bricking/import/source/oriented_source.h"
#include "bricking/import/source/plausible.h"
#include "core/base/error.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <limits>
#include <map>
#include <vector>

namespace tessera {
namespace {

constexpr int kAxes = 3;

std::optional<FileType> typeOf(const std::string& word) {
    static const std::map<std::string, FileType> types = {
        {"MET_CHAR", FileType::i8},       {"MET_UCHAR", FileType::u8},       {"MET_SHORT", FileType::i16},
        {"MET_USHORT", FileType::u16},    {"MET_INT", FileType::i32},        {"MET_UINT", FileType::u32},
        {"MET_LONG", FileType::i32},      {"MET_ULONG", FileType::u32}, // four bytes, whatever a machine has
        {"MET_LONG_LONG", FileType::i64}, {"MET_ULONG_LONG", FileType::u64}, {"MET_FLOAT", FileType::f32},
        {"MET_DOUBLE", FileType::f64}};
    const auto at = types.find(word);
    return at == types.end() ? std::nullopt : std::optional(at->second);
}

/// "RAI": where the axes of a volume begin, as MetaIO writes it.
std::string anatomyOf(const VolumeInfo& info) {
    const AxisOrder order = nearestLpsOrder(info.patientFromVoxel);
    std::string text(kAxes, '?');
    for (std::size_t axis = 0; axis < kAxes; ++axis)
        text[static_cast<std::size_t>(order.sourceAxis[axis])] = (order.flipped[axis] ? "LPS" : "RAI")[axis];
    return text;
}

class MetaReader {
  public:
    MetaReader(const InputFile& file, const std::optional<glm::dvec3>& spacingMm)
        : path_(file.path()), where_(path_.string()), fileBytes_(file.sizeBytes()), spacingMm_(spacingMm),
          lines_(file, "MetaImage") {}

    MetaHeader read() {
        takeLines();
        if (text("objecttype", "Image") != "Image")
            refuse("a MetaImage: ObjectType = Image", shownWord(text("objecttype", "")));
        if (whole("ndims", 1, 16) != kAxes)
            refuse("NDims = 3", text("ndims", ""));
        readCoding();
        readPlace();
        readData();
        header_.info.validate(where_);
        return std::move(header_);
    }

  private:
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(where_, expected, found);
    }

    void takeLines() {
        while (const std::optional<std::string> line = lines_.next()) {
            if (withoutBlanks(*line).empty())
                continue;
            const std::size_t at = line->find_first_of("=:");
            if (at == std::string::npos)
                refuse("lines \"Name = value\" in the MetaImage header", shownWord(*line));
            const std::string name = lowered(withoutBlanks(std::string_view(*line).substr(0, at)));
            std::string value(withoutBlanks(std::string_view(*line).substr(at + 1)));
            if (fields_.empty() && name != "objecttype" && name != "ndims" && name != "comment")
                refuse("a MetaImage header, which begins with ObjectType or NDims", shownWord(*line));
            if (!fields_.emplace(name, std::move(value)).second && name != "comment")
                refuse("every MetaImage field once", "\"" + name + "\" again");
            if (name != "elementdatafile")
                continue;
            header_.files.bytes = lines_.readBytes();
            if (fields_[name].starts_with("LIST"))
                while (const std::optional<std::string> file = lines_.next())
                    if (!withoutBlanks(*file).empty())
                        listed_.emplace_back(withoutBlanks(*file));
            return;
        }
        refuse("the MetaImage field \"ElementDataFile\", the header's last",
               "the end of the file (is it truncated?)");
    }

    const std::string* field(const std::string& name) const {
        const auto at = fields_.find(name);
        return at == fields_.end() ? nullptr : &at->second;
    }
    std::string text(const std::string& name, const std::string& fallback) const {
        const std::string* value = field(name);
        return value ? *value : fallback;
    }
    const std::string& required(const std::string& name) const {
        if (const std::string* value = field(name))
            return *value;
        refuse("the MetaImage field \"" + name + "\"", "a header without it");
    }
    std::int64_t whole(const std::string& name, std::int64_t least, std::int64_t most) const {
        const std::optional<std::int64_t> value = wholeNumberOf(required(name));
        if (!value || *value < least || *value > most)
            refuse("\"" + name + "\" as a whole number from " + std::to_string(least) + " to " +
                       std::to_string(most),
                   shownWord(required(name)));
        return *value;
    }
    bool isTrue(const std::string& name, bool fallback) const {
        const std::string* value = field(name);
        if (!value)
            return fallback;
        const std::string word = lowered(*value);
        if (word == "true" || word == "t" || word == "1" || word == "yes")
            return true;
        if (word != "false" && word != "f" && word != "0" && word != "no")
            refuse("\"" + name + "\" True or False", shownWord(*value));
        return false;
    }
    /// The first of several names of a field that the header has; empty: none.
    std::vector<double> numbers(std::initializer_list<const char*> names, std::size_t count) const {
        for (const char* const name : names) {
            const std::string* value = field(name);
            if (!value)
                continue;
            std::vector<double> out;
            for (const std::string& word : wordsOf(*value)) {
                const std::optional<double> number = realNumberOf(word);
                if (!number || !std::isfinite(*number))
                    refuse("\"" + std::string(name) + "\" of finite numbers", shownWord(*value));
                out.push_back(*number);
            }
            if (out.size() != count)
                refuse("\"" + std::string(name) + "\" of " + std::to_string(count) + " numbers",
                       shownWord(*value));
            return out;
        }
        return {};
    }

    void readCoding() {
        DataFiles& files = header_.files;
        std::uint64_t values = 1;
        const std::vector<std::string> sizes = wordsOf(required("dimsize"));
        if (sizes.size() != kAxes)
            refuse("\"DimSize\" of 3 numbers", shownWord(required("dimsize")));
        for (int axis = 0; axis < kAxes; ++axis) {
            const std::optional<std::int64_t> size = wholeNumberOf(sizes[static_cast<std::size_t>(axis)]);
            constexpr std::uint64_t kMostValues = std::uint64_t{1} << 58;
            if (!size || *size < 1 || *size > std::numeric_limits<std::int32_t>::max() ||
                values > kMostValues / static_cast<std::uint64_t>(*size))
                refuse("\"DimSize\" of whole numbers of at least 1, and 2^58 values at most",
                       shownWord(required("dimsize")));
            values *= static_cast<std::uint64_t>(*size);
            files.sizes.push_back(*size);
            header_.info.extentVoxels[axis] = static_cast<int>(*size);
        }
        const std::string& type = required("elementtype");
        const std::optional<FileType> known = typeOf(type);
        if (!known)
            refuse("an \"ElementType\" of single numbers, such as MET_SHORT", shownWord(type));
        files.type = *known;
        if (const std::string* channels = field("elementnumberofchannels"); channels && *channels != "1")
            refuse("a volume of one value per voxel: ElementNumberOfChannels = 1", shownWord(*channels));
        if (!isTrue("binarydata", true))
            files.encoding = DataEncoding::text;
        const bool isPacked = isTrue("compresseddata", false);
        if (isPacked && files.encoding == DataEncoding::text)
            refuse("compressed data that are binary", "BinaryData = False");
        if (isPacked)
            files.encoding = DataEncoding::gzip;
        if (isPacked && field("compresseddatasize"))
            header_.packedBytes =
                static_cast<std::uint64_t>(whole("compresseddatasize", 0, std::int64_t{1} << 53));
        const bool hasOrder = field("elementbyteordermsb") || field("binarydatabyteordermsb");
        files.bigEndian = isTrue("elementbyteordermsb", isTrue("binarydatabyteordermsb", false));
        if (files.bigEndian != isTrue("binarydatabyteordermsb", files.bigEndian))
            refuse("one order of bytes", "ElementByteOrderMSB and BinaryDataByteOrderMSB that differ");
        if (!hasOrder && files.encoding != DataEncoding::text && bytesPerFileValue(files.type) > 1)
            header_.info.remarks.emplace_back("the order of bytes is not stated; taken as little endian");
        header_.info.type = storedTypeOf(dataType(files));
        readRescale();
        static const std::map<std::string, const char*> modalities = {
            {"MET_MOD_CT", "CT"}, {"MET_MOD_MR", "MR"}, {"MET_MOD_NM", "NM"}, {"MET_MOD_US", "US"}};
        if (const auto at = modalities.find(text("modality", "")); at != modalities.end())
            header_.info.acquisition.modality = at->second;
    }

    void readRescale() {
        const std::vector<double> slope = numbers({"elementtointensityfunctionslope"}, 1),
                                  offset = numbers({"elementtointensityfunctionoffset"}, 1);
        if (slope.empty() && offset.empty())
            return;
        header_.info.rescaleSlope = slope.empty() ? 1 : slope.front();
        header_.info.rescaleIntercept = offset.empty() ? 0 : offset.front();
        const FileType type = header_.files.type;
        constexpr int kExactBits = 24; // of whole numbers in a float
        const double largest =
            type == FileType::f32 || type == FileType::f64
                ? 0
                : std::ldexp(1.0, std::min(kExactBits, static_cast<int>(8 * bytesPerFileValue(type))));
        requirePlausibleRescale(header_.info.rescaleSlope, header_.info.rescaleIntercept, largest, false,
                                "ElementToIntensityFunctionSlope", "ElementToIntensityFunctionOffset",
                                where_);
    }

    void readPlace() {
        const std::string unit = text("distanceunits", "?");
        static const std::map<std::string, double> units = {{"?", 1}, {"mm", 1}, {"cm", 10}, {"um", 1e-3}};
        const auto mm = units.find(lowered(unit));
        if (mm == units.end())
            refuse("DistanceUnits um, mm or cm", shownWord(unit));
        std::vector<double> spacing = numbers({"elementspacing", "elementsize"}, kAxes);
        header_.saysSpacing = !spacing.empty();
        for (double& length : spacing) {
            if (!(length > 0))
                refuse("\"ElementSpacing\" above 0",
                       shownWord(text("elementspacing", text("elementsize", ""))));
            length *= mm->second;
        }
        const glm::dvec3 given = spacingMm_.value_or(glm::dvec3(1));
        if (spacing.empty())
            spacing = {given.x, given.y, given.z};
        std::vector<double> axes = numbers({"transformmatrix", "rotation", "orientation"}, kAxes * kAxes);
        header_.info.orientationKnown = !axes.empty();
        if (axes.empty())
            axes = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        std::vector<double> origin = numbers({"offset", "position", "origin"}, kAxes);
        origin.resize(kAxes, 0);
        std::array<glm::dvec3, kAxes> step;
        for (std::size_t axis = 0; axis < kAxes; ++axis) {
            step[axis] = {axes[kAxes * axis], axes[kAxes * axis + 1], axes[kAxes * axis + 2]};
            constexpr double kRounding = 1e-3; // of a length of 1
            if (!(std::abs(glm::length(step[axis]) - 1) < kRounding))
                refuse("\"TransformMatrix\" of directions of length 1 (lengths belong in ElementSpacing)",
                       "length " + std::to_string(glm::length(step[axis])));
            step[axis] *= spacing[axis];
        }
        header_.info.patientFromVoxel = patientFromVoxelOf(
            mm->second * glm::dvec3(origin[0], origin[1], origin[2]), step[0], step[1], step[2]);
        requirePlausibleGeometry(header_.info, {"ElementSpacing", "TransformMatrix", "Offset"}, where_);
        const std::string anatomy = text("anatomicalorientation", "");
        if (header_.info.orientationKnown && anatomy.size() == kAxes && anatomy.find('?') == anatomy.npos &&
            anatomy != anatomyOf(header_.info))
            header_.info.remarks.push_back(
                "AnatomicalOrientation contradicts TransformMatrix, which is taken");
    }

    void readData() {
        DataFiles& files = header_.files;
        if (required("elementdatafile").empty())
            refuse("a name after \"ElementDataFile\"", "none (is it truncated?)");
        const std::string& named = required("elementdatafile");
        const bool isLocal = named == "LOCAL" || named == "Local" || named == "local"; // as MetaIO has it
        if (!isLocal)
            files.dataFiles = namedDataFiles("ElementDataFile", named, listed_, files.sizes, path_);
        if (field("headersize")) {
            files.byteSkip = whole("headersize", -1, std::int64_t{1} << 53);
            if (files.byteSkip != 0 && files.encoding != DataEncoding::raw)
                refuse("HeaderSize with data that are neither compressed nor text", text("headersize", ""));
            if (files.byteSkip > 0 && isLocal)
                refuse("HeaderSize with data in another file", "ElementDataFile = LOCAL");
        }
        if (header_.packedBytes > 0 && isLocal && fileBytes_ - files.bytes < header_.packedBytes)
            refuse(std::to_string(header_.packedBytes) + " bytes of compressed data",
                   std::to_string(fileBytes_ - files.bytes) + " (is it truncated?)");
    }

    std::filesystem::path path_;
    std::string where_;
    std::uint64_t fileBytes_;
    std::optional<glm::dvec3> spacingMm_;
    HeaderLines lines_;
    MetaHeader header_;
    std::map<std::string, std::string> fields_; // by their names in lower case
    std::vector<std::string> listed_;           // data files
};

} // namespace

MetaHeader readMetaHeader(const std::filesystem::path& path, const std::optional<glm::dvec3>& spacingMm) {
    const InputFile file(path);
    return MetaReader(file, spacingMm).read();
}

} // namespace tessera
