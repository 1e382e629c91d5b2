// tests/support/dicom_writer.h: writes small DICOM files, explicit VR little endian, with every value that
// matters under the test's control and identifiers planted in all of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace tessera::test {

/// What is planted in every file; none of it may ever come out again.
inline const std::vector<std::string> kPlanted = {
    "PLANTED^PATIENT",  "PLANTED-ID-4711", "19470301",        "20230517",         "PLANTED DESCRIPTION",
    "PLANTED HOSPITAL", "1.2.826.99.4711", "PLANTED-ACC-12",  "PLANTED^REFERRER", "PLANTED STREET 5",
    "PLANTED COMMENT",  "PLANTED STATION", "PLANTED PRIVATE", "083015.4711"};

struct DicomImage {
    int columns = 4, rows = 3, frames = 1;
    std::vector<std::uint16_t> pixels; // [frame][y][x], raw words
    int bitsAllocated = 16, bitsStored = 16, pixelRepresentation = 1;
    std::optional<std::string> slope = "1", intercept = "-1024";
    std::optional<int> padding, paddingLimit;
    std::optional<std::string> betweenSlices; // SpacingBetweenSlices
    std::optional<glm::dvec3> position = glm::dvec3(0);
    std::vector<glm::dvec3> framePositions; // multi-frame only
    glm::dvec3 rowDirection{1, 0, 0}, columnDirection{0, 1, 0};
    double spacingX = 0.5, spacingY = 0.7; // PixelSpacing is written as Y\X
    std::string series = "1", modality = "CT";
    bool withPixels = true;
    std::string storageClass = "1.2.840.10008.5.1.4.1.1.2";
    std::string syntax = "1.2.840.10008.1.2.1"; // of the pixels; another one goes with fragments
    std::vector<std::string> fragments;         // compressed: instead of pixels
    std::vector<std::uint32_t> fragmentOffsets; // of the frames, from the first fragment's item
    std::optional<int> largestPixel, highBit;
    bool modalityTable = false; // a ModalityLUTSequence
    std::string patientSuffix, frameOfReference;
    std::optional<std::string> lossy, lossyRatio; // LossyImageCompression "01" and its ratio
    std::string imageType;                        // "ORIGINAL\\PRIMARY\\LOCALIZER"
    std::optional<int> acquisition, temporalPosition;
    std::optional<double> cardiacPercent;
    std::optional<std::string> acquisitionTime, contentTime;               // "083015.25"
    std::optional<std::string> positionText, orientationText, spacingText; // written instead
    int samplesPerPixel = 1;
    bool preamble = true, implicitVr = false; // implicit: without a preamble only
    std::string kernel = "B30f", voltage = "120", thickness = "1.5", photometric = "MONOCHROME2";
    int instance = 1;                                       // says nothing: order comes from positions
    std::optional<std::string> seriesNumber, seriesDate;    // "3", "20230518"
    std::optional<std::string> seriesUid, patient, station; // written instead; "" an empty value
    std::string charset, patientName = kPlanted[0];
    std::map<unsigned, std::string> vrs;                          // by tag, 0x00280030: written with this VR
    std::set<unsigned> without;                                   // tags that are left out
    std::map<unsigned, std::pair<std::string, std::string>> more; // elements besides: VR and value, by tag
    char filling = ' ';                                           // what makes texts even
};

class DicomBytes {
  public:
    void u16(unsigned v) {
        bytes_ += static_cast<char>((bigEndian ? v >> 8 : v) & 255);
        bytes_ += static_cast<char>((bigEndian ? v : v >> 8) & 255);
    }
    void u32(std::size_t v) {
        u16((bigEndian ? v >> 16 : v) & 0xffff);
        u16((bigEndian ? v : v >> 16) & 0xffff);
    }
    void element(unsigned group, unsigned tag, const char* usualVr, std::string value) {
        while (!more.empty() && more.begin()->first < (group << 16 | tag)) {
            const auto [at, element] = *more.begin();
            more.erase(more.begin());
            this->element(at >> 16, at & 0xffff, element.first.c_str(), element.second);
        }
        const auto other = vrs.find(group << 16 | tag);
        const std::string vr = other == vrs.end() ? usualVr : other->second;
        if (without.contains(group << 16 | tag))
            return;
        const bool longForm = std::string("OB OW SQ UN UT").find(vr) != std::string::npos;
        if (value.size() % 2)
            value += vr == "UI" ? '\0' : filling;
        u16(group), u16(tag);
        if (implicitVr) {
            u32(value.size());
            bytes_ += value;
            return;
        }
        bytes_ += vr;
        if (longForm)
            u16(0), u32(value.size());
        else
            u16(static_cast<unsigned>(value.size()));
        bytes_ += value;
    }
    /// Compressed pixels: the table of offsets, which may be empty, then a fragment an item.
    void encapsulated(const std::vector<std::string>& fragments, const std::vector<std::uint32_t>& offsets) {
        u16(0x7fe0), u16(0x10);
        bytes_ += "OB";
        u16(0), u32(0xffffffff);
        DicomBytes table;
        for (const std::uint32_t offset : offsets)
            table.u32(offset);
        bytes_ += item(table.bytes());
        for (const std::string& fragment : fragments)
            bytes_ += item(fragment + (fragment.size() % 2 ? std::string(1, '\0') : ""));
        u16(0xfffe), u16(0xe0dd), u32(0);
    }
    void number(unsigned group, unsigned tag, int value, const char* vr = "US") {
        DicomBytes b;
        b.bigEndian = bigEndian;
        b.u16(static_cast<unsigned>(value) & 0xffff);
        element(group, tag, vr, b.bytes_);
    }
    /// One item of a sequence.
    static std::string item(const std::string& content) {
        DicomBytes b;
        b.u16(0xfffe), b.u16(0xe000), b.u32(content.size());
        return b.bytes_ + content;
    }
    const std::string& bytes() const { return bytes_; }
    std::string bytes_;
    bool implicitVr = false, bigEndian = false;
    std::map<unsigned, std::string> vrs;
    std::set<unsigned> without;
    std::map<unsigned, std::pair<std::string, std::string>> more;
    char filling = ' ';
};

inline std::string decimals(std::initializer_list<double> values) {
    std::string text;
    for (const double v : values) {
        char one[32];
        std::snprintf(one, sizeof one, "%s%.8g", text.empty() ? "" : "\\", v);
        text += one;
    }
    return text;
}
inline std::string decimals(const glm::dvec3& v) {
    return decimals({v.x, v.y, v.z});
}

inline std::string dicomBytes(const DicomImage& image) {
    static int instance = 0; // every file needs its own UID
    const std::string uid = kPlanted[6] + "." + image.series + "." + std::to_string(++instance);
    DicomBytes meta, d;
    d.implicitVr = image.implicitVr;
    d.vrs = image.vrs;
    d.more = image.more;
    d.without = image.without;
    d.filling = image.filling;
    d.bigEndian = image.syntax == "1.2.840.10008.1.2.2"; // of the data set; the meta group is always little
    meta.element(0x2, 0x2, "UI", image.storageClass);
    meta.element(0x2, 0x3, "UI", uid);
    meta.element(0x2, 0x10, "UI", image.syntax);
    if (!image.charset.empty())
        d.element(0x8, 0x5, "CS", image.charset);
    if (!image.imageType.empty())
        d.element(0x8, 0x8, "CS", image.imageType);
    d.element(0x8, 0x16, "UI", image.storageClass);
    d.element(0x8, 0x18, "UI", uid);
    d.element(0x8, 0x20, "DA", kPlanted[3]);
    if (image.seriesDate)
        d.element(0x8, 0x21, "DA", *image.seriesDate);
    d.element(0x8, 0x30, "TM", kPlanted[13]);
    if (image.acquisitionTime)
        d.element(0x8, 0x32, "TM", *image.acquisitionTime);
    if (image.contentTime)
        d.element(0x8, 0x33, "TM", *image.contentTime);
    d.element(0x8, 0x50, "SH", kPlanted[7]);
    d.element(0x8, 0x60, "CS", image.modality);
    d.element(0x8, 0x80, "LO", kPlanted[5]);
    d.element(0x8, 0x90, "PN", kPlanted[8]);
    d.element(0x8, 0x1010, "SH", image.station.value_or(kPlanted[11]));
    d.element(0x8, 0x103e, "LO", kPlanted[4]);
    d.element(0x9, 0x10, "LO", kPlanted[12]);
    d.element(0x10, 0x10, "PN", image.patientName);
    d.element(0x10, 0x20, "LO", image.patient.value_or(kPlanted[1] + image.patientSuffix));
    d.element(0x10, 0x30, "DA", kPlanted[2]);
    d.element(0x10, 0x1040, "LO", kPlanted[9]);
    d.element(0x10, 0x4000, "LT", kPlanted[10]);
    d.element(0x18, 0x50, "DS", image.thickness);
    d.element(0x18, 0x60, "DS", image.voltage);
    if (image.betweenSlices)
        d.element(0x18, 0x88, "DS", *image.betweenSlices);
    d.element(0x18, 0x1210, "SH", image.kernel);
    d.element(0x20, 0xd, "UI", kPlanted[6]);
    d.element(0x20, 0xe, "UI", image.seriesUid.value_or(kPlanted[6] + ".7." + image.series));
    if (image.seriesNumber)
        d.element(0x20, 0x11, "IS", *image.seriesNumber);
    if (image.acquisition)
        d.element(0x20, 0x12, "IS", std::to_string(*image.acquisition));
    d.element(0x20, 0x13, "IS", std::to_string(image.instance));
    const std::string orientation =
        image.orientationText.value_or(decimals(image.rowDirection) + "\\" + decimals(image.columnDirection));
    if (image.framePositions.empty()) {
        if (image.position)
            d.element(0x20, 0x32, "DS", image.positionText.value_or(decimals(*image.position)));
        d.element(0x20, 0x37, "DS", orientation);
    }
    if (image.temporalPosition)
        d.element(0x20, 0x100, "IS", std::to_string(*image.temporalPosition));
    if (image.cardiacPercent) {
        std::string raw(sizeof(double), '\0');
        std::memcpy(raw.data(), &*image.cardiacPercent, sizeof(double));
        d.element(0x20, 0x9241, "FD", raw);
    }
    if (!image.frameOfReference.empty())
        d.element(0x20, 0x52, "UI", image.frameOfReference);
    d.number(0x28, 0x2, image.samplesPerPixel);
    d.element(0x28, 0x4, "CS", image.photometric);
    if (image.frames > 1)
        d.element(0x28, 0x8, "IS", std::to_string(image.frames));
    d.number(0x28, 0x10, image.rows);
    d.number(0x28, 0x11, image.columns);
    d.element(0x28, 0x30, "DS", image.spacingText.value_or(decimals({image.spacingY, image.spacingX})));
    d.number(0x28, 0x100, image.bitsAllocated);
    d.number(0x28, 0x101, image.bitsStored);
    d.number(0x28, 0x102, image.highBit.value_or(image.bitsStored - 1));
    d.number(0x28, 0x103, image.pixelRepresentation);
    if (image.largestPixel)
        d.number(0x28, 0x107, *image.largestPixel, image.pixelRepresentation ? "SS" : "US");
    if (image.padding)
        d.number(0x28, 0x120, *image.padding, image.pixelRepresentation ? "SS" : "US");
    if (image.paddingLimit)
        d.number(0x28, 0x121, *image.paddingLimit, image.pixelRepresentation ? "SS" : "US");
    if (image.intercept)
        d.element(0x28, 0x1052, "DS", *image.intercept);
    if (image.slope)
        d.element(0x28, 0x1053, "DS", *image.slope);
    if (image.lossy)
        d.element(0x28, 0x2110, "CS", *image.lossy);
    if (image.lossyRatio)
        d.element(0x28, 0x2112, "DS", *image.lossyRatio);
    if (image.modalityTable)
        d.element(0x28, 0x3000, "SQ", DicomBytes::item(""));
    if (!image.framePositions.empty()) {
        DicomBytes plane, shared;
        plane.element(0x20, 0x37, "DS", orientation);
        shared.element(0x20, 0x9116, "SQ", DicomBytes::item(plane.bytes()));
        d.element(0x5200, 0x9229, "SQ", DicomBytes::item(shared.bytes()));
        std::string items;
        for (const glm::dvec3& position : image.framePositions) {
            DicomBytes place, groups;
            place.element(0x20, 0x32, "DS", decimals(position));
            groups.element(0x20, 0x9113, "SQ", DicomBytes::item(place.bytes()));
            items += DicomBytes::item(groups.bytes());
        }
        d.element(0x5200, 0x9230, "SQ", items);
    }
    if (!image.fragments.empty()) {
        d.encapsulated(image.fragments, image.fragmentOffsets);
    } else if (image.withPixels) {
        DicomBytes words;
        words.bigEndian = d.bigEndian;
        for (const std::uint16_t word : image.pixels)
            words.u16(word);
        d.element(0x7fe0, 0x10, "OW", words.bytes());
    }
    if (!image.preamble)
        return d.bytes();
    DicomBytes length;
    DicomBytes four;
    four.u32(meta.bytes().size());
    length.element(0x2, 0x0, "UL", four.bytes());
    return std::string(128, '\0') + "DICM" + length.bytes() + meta.bytes() + d.bytes();
}

inline void writeDicom(const std::filesystem::path& path, const DicomImage& image) {
    std::ofstream file(path, std::ios::binary);
    const std::string bytes = dicomBytes(image);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

} // namespace tessera::test
