// tests/support/segmentation_writer.h: writes small DICOM Segmentations, explicit VR little endian, with
// identifiers planted in all of them.
#pragma once

#include "tests/support/dicom_writer.h"

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera::test {

struct SegSegment {
    int number = 1;
    std::string label = "liver", category = "Tissue";
    std::optional<std::array<int, 3>> lab = {};
};

struct SegTestFrame {
    int segment = 1;
    std::optional<glm::dvec3> position = glm::dvec3(0);
    std::vector<std::uint16_t> pixels;           // [y][x]
    std::optional<std::string> orientation = {}; // of its own: "1\\0\\0\\0\\1\\0"
};

struct SegImage {
    std::string type = "BINARY", fractionalType = "PROBABILITY";
    std::string storageClass = "1.2.840.10008.5.1.4.1.1.66.4", syntax = "1.2.840.10008.1.2.1";
    int rows = 3, columns = 5, bits = 1, most = 255;
    std::vector<SegSegment> segments = {{}};
    std::vector<SegTestFrame> frames;
    std::string orientation = "1\\0\\0\\0\\1\\0", spacing = "2\\1", between, thickness = "3", characters;
    std::string frame = "1.2.3.99"; // of reference
    std::optional<int> padding, framesSaid;
    std::vector<std::string> fragments;    // instead of pixels
    std::optional<std::string> pixelBytes; // instead of them
};

inline std::string itemsOf(const std::vector<std::string>& items) {
    std::string all;
    for (const std::string& item : items)
        all += DicomBytes::item(item);
    return all;
}

/// As DICOM packs them: bits of all frames without filling, the lowest first; or little-endian values.
inline std::string segPixelBytes(const SegImage& image) {
    std::string bytes;
    std::size_t bit = 0;
    for (const SegTestFrame& frame : image.frames)
        for (const std::uint16_t value : frame.pixels) {
            if (image.bits == 1) {
                if (bit % 8 == 0)
                    bytes += '\0';
                if (value)
                    bytes.back() = static_cast<char>(bytes.back() | 1 << bit % 8);
                ++bit;
            } else {
                bytes += static_cast<char>(value & 255);
                if (image.bits == 16)
                    bytes += static_cast<char>(value >> 8);
            }
        }
    return bytes;
}

inline std::string segDataSet(const SegImage& image) {
    DicomBytes d;
    d.implicitVr = image.syntax == "1.2.840.10008.1.2";
    const DicomBytes none = d;
    if (!image.characters.empty())
        d.element(0x8, 0x5, "CS", image.characters);
    d.element(0x8, 0x16, "UI", image.storageClass);
    d.element(0x8, 0x18, "UI", "1.2.3.4");
    d.element(0x8, 0x20, "DA", kPlanted[3]);
    d.element(0x8, 0x60, "CS", "SEG");
    d.element(0x8, 0x90, "PN", kPlanted[8]);
    d.element(0x10, 0x10, "PN", kPlanted[0]);
    d.element(0x10, 0x20, "LO", kPlanted[1]);
    d.element(0x20, 0x52, "UI", image.frame);
    d.number(0x28, 0x2, 1);
    d.element(0x28, 0x4, "CS", "MONOCHROME2");
    d.element(0x28, 0x8, "IS",
              std::to_string(image.framesSaid.value_or(static_cast<int>(image.frames.size()))));
    d.number(0x28, 0x10, image.rows);
    d.number(0x28, 0x11, image.columns);
    d.number(0x28, 0x100, image.bits);
    d.number(0x28, 0x101, image.bits);
    d.number(0x28, 0x102, image.bits - 1);
    d.number(0x28, 0x103, 0);
    if (image.padding)
        d.number(0x28, 0x120, *image.padding);
    d.element(0x62, 0x1, "CS", image.type);
    std::vector<std::string> segments;
    for (const SegSegment& segment : image.segments) {
        DicomBytes s = none, code = none;
        code.element(0x8, 0x100, "SH", "1");
        code.element(0x8, 0x102, "SH", "99X");
        code.element(0x8, 0x104, "LO", segment.category);
        s.element(0x62, 0x3, "SQ", DicomBytes::item(code.bytes()));
        s.number(0x62, 0x4, segment.number);
        s.element(0x62, 0x5, "LO", segment.label);
        s.element(0x62, 0x8, "CS", "MANUAL");
        if (segment.lab) {
            DicomBytes lab;
            for (const int part : *segment.lab)
                lab.u16(static_cast<unsigned>(part));
            s.element(0x62, 0xd, "US", lab.bytes());
        }
        s.element(0x62, 0xf, "SQ", DicomBytes::item(code.bytes()));
        segments.push_back(s.bytes());
    }
    d.element(0x62, 0x2, "SQ", itemsOf(segments));
    if (image.type == "FRACTIONAL") {
        d.number(0x62, 0xe, image.most);
        d.element(0x62, 0x10, "CS", image.fractionalType);
    }
    DicomBytes plane = none, measures = none, shared = none;
    plane.element(0x20, 0x37, "DS", image.orientation);
    if (!image.thickness.empty())
        measures.element(0x18, 0x50, "DS", image.thickness);
    if (!image.between.empty())
        measures.element(0x18, 0x88, "DS", image.between);
    measures.element(0x28, 0x30, "DS", image.spacing);
    shared.element(0x20, 0x9116, "SQ", DicomBytes::item(plane.bytes()));
    shared.element(0x28, 0x9110, "SQ", DicomBytes::item(measures.bytes()));
    d.element(0x5200, 0x9229, "SQ", DicomBytes::item(shared.bytes()));
    std::vector<std::string> frames;
    for (const SegTestFrame& frame : image.frames) {
        DicomBytes groups = none, place = none, segment = none, own = none;
        if (frame.position) {
            place.element(0x20, 0x32, "DS", decimals(*frame.position));
            groups.element(0x20, 0x9113, "SQ", DicomBytes::item(place.bytes()));
        }
        if (frame.orientation) {
            own.element(0x20, 0x37, "DS", *frame.orientation);
            groups.element(0x20, 0x9116, "SQ", DicomBytes::item(own.bytes()));
        }
        if (image.type != "LABELMAP") {
            segment.number(0x62, 0xb, frame.segment);
            groups.element(0x62, 0xa, "SQ", DicomBytes::item(segment.bytes()));
        }
        frames.push_back(groups.bytes());
    }
    d.element(0x5200, 0x9230, "SQ", itemsOf(frames));
    if (!image.fragments.empty())
        d.encapsulated(image.fragments, {});
    else
        d.element(0x7fe0, 0x10, "OB", image.pixelBytes.value_or(segPixelBytes(image)));
    return d.bytes();
}

/// @param dataSet  instead of segDataSet(image), such as a deflated one
inline std::string segFileBytes(const SegImage& image, const std::optional<std::string>& dataSet = {}) {
    DicomBytes meta, length, four;
    meta.element(0x2, 0x2, "UI", image.storageClass);
    meta.element(0x2, 0x3, "UI", "1.2.3.4");
    meta.element(0x2, 0x10, "UI", image.syntax);
    four.u32(meta.bytes().size());
    length.element(0x2, 0x0, "UL", four.bytes());
    return std::string(128, '\0') + "DICM" + length.bytes() + meta.bytes() +
           dataSet.value_or(segDataSet(image));
}

} // namespace tessera::test
