// bricking/import/files/stack/ome_text.cpp: see ome_text.h. Rules: the OME-TIFF specification, schema
// 2016-06.
#include "bricking/import/files/stack/ome_text.h"

#include "bricking/import/files/header_words.h"
#include "bricking/import/source/length_units.h"
#include "bricking/import/source/time_units.h"

namespace tessera {
namespace {

/// 0: no number, or none that counts.
std::int64_t sizeOf(const XmlTag& tag, std::string_view key, std::int64_t fallback) {
    const std::string text = xmlAttribute(tag, key);
    constexpr std::int64_t kMost = std::int64_t{1} << 31;
    if (text.empty())
        return fallback;
    const std::optional<std::int64_t> size = wholeNumberOf(text);
    return size && *size >= 1 && *size <= kMost ? *size : 0;
}

/// Of a plane or page, from 0 on; -1: no number.
std::optional<std::int64_t> placeOf(const XmlTag& tag, std::string_view key) {
    const std::string text = xmlAttribute(tag, key);
    if (text.empty())
        return std::nullopt;
    const std::int64_t place = wholeNumberOf(text).value_or(-1);
    constexpr std::int64_t kMost = std::int64_t{1} << 31;
    return place >= 0 && place <= kMost ? place : -1;
}

std::optional<double> lengthOf(const XmlTag& pixels, const std::string& axis) {
    const std::string unit = xmlAttribute(pixels, "PhysicalSize" + axis + "Unit");
    constexpr double kMicrometre = 1e-3; // the format's own unit
    const double mm = (unit.empty() ? kMicrometre : millimetresOf(unit)) *
                      realNumberOf(xmlAttribute(pixels, "PhysicalSize" + axis)).value_or(0);
    return isLength(mm) ? std::optional(mm) : std::nullopt;
}

OmeTiffImage imageOf(const XmlTag& pixels) {
    OmeTiffImage image;
    image.order = xmlAttribute(pixels, "DimensionOrder");
    image.width = sizeOf(pixels, "SizeX", -1);
    image.height = sizeOf(pixels, "SizeY", -1);
    image.slices = sizeOf(pixels, "SizeZ", 1);
    image.channels = sizeOf(pixels, "SizeC", 1);
    image.times = sizeOf(pixels, "SizeT", 1);
    const std::optional<double> x = lengthOf(pixels, "X"), y = lengthOf(pixels, "Y");
    if (x && y)
        image.pixelMm = glm::dvec2(*x, *y);
    image.sliceMm = lengthOf(pixels, "Z");
    const std::string unit = xmlAttribute(pixels, "TimeIncrementUnit");
    image.stepSeconds = stepSecondsOf(realNumberOf(xmlAttribute(pixels, "TimeIncrement")).value_or(0),
                                      unit.empty() ? "s" : unit);
    return image;
}

OmeBlock blockOf(const XmlTag& tag) {
    OmeBlock block;
    block.page = placeOf(tag, "IFD");
    block.planes = placeOf(tag, "PlaneCount");
    block.slice = placeOf(tag, "FirstZ").value_or(0);
    block.channel = placeOf(tag, "FirstC").value_or(0);
    block.time = placeOf(tag, "FirstT").value_or(0);
    return block;
}

} // namespace

bool isOfOme(std::string_view description) {
    return description.find("<OME") != std::string_view::npos ||
           description.find(":OME ") != std::string_view::npos;
}

OmeText readOmeText(std::string_view description) {
    OmeText text;
    bool isInBlock = false;
    for (const XmlTag& tag : xmlTagsOf(description)) {
        if (tag.name == "OME") {
            text.isWhole = text.isWhole || tag.closes;
            if (tag.opens)
                text.uuid = xmlAttribute(tag, "UUID");
        } else if (tag.name == "TiffData") {
            isInBlock = tag.opens && !tag.closes;
            if (tag.opens && !text.images.empty())
                text.images.back().blocks.push_back(blockOf(tag));
        } else if (!tag.opens) {
            continue;
        } else if (tag.name == "BinaryOnly") {
            text.describedBy = xmlAttribute(tag, "MetadataFile");
        } else if (tag.name == "Pixels") {
            text.images.push_back(imageOf(tag));
        } else if (tag.name == "Channel" && !text.images.empty()) {
            text.images.back().channelNames.push_back(xmlAttribute(tag, "Name"));
        } else if (tag.name == "UUID" && isInBlock && !text.images.empty()) {
            OmeBlock& block = text.images.back().blocks.back();
            block.file = xmlAttribute(tag, "FileName");
            block.uuid = std::string(withoutBlanks(tag.text));
        }
    }
    return text;
}

} // namespace tessera
