// bricking/import/dicom/dicom_scan.h: reads the headers of DICOM files and groups the slices by series. It
// keeps the few values that a volume needs. Everything else in a header, including every identifier, is
// dropped here.
#pragma once

#include "bricking/import/codecs/stream.h"
#include "bricking/import/dicom/encapsulated_frames.h"
#include "bricking/import/dicom/folder_walk.h"
#include "core/base/volume.h"

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// The storage of a slice's pixels in its file.
enum class PixelCoding : std::uint8_t {
    littleEndian, // plain, read by position
    bigEndian,    // plain, read by position
    deflated,     // the whole data set is deflated; the offset is in the inflated data
    compressed    // a compressed stream in fragments
};

/// The expected and the actual content of a header, in words that quote no value.
struct HeaderFault {
    std::string expected, found;
    bool operator==(const HeaderFault&) const = default;
};

/// Time and kind of a slice, by its header: distinguishes images at one position. For sorting and for the
/// list of phases; a time of day is never shown.
struct SliceMoment {
    std::optional<double> cardiacPercent;                   // NominalPercentageOfCardiacPhase
    std::optional<double> triggerMs;                        // TriggerTime, after the R wave
    std::optional<int> temporalPosition, acquisition, echo; // numbers of headers
    std::optional<double> acquisitionSecond, contentSecond; // of the day
    bool operator==(const SliceMoment&) const = default;
};

/// One image: a file, or a frame of a multi-frame file.
struct DicomSlice {
    std::filesystem::path file;
    std::uint64_t pixelOffsetBytes = 0; // plain codings: of this frame
    PixelCoding coding = PixelCoding::littleEndian;
    int columns = 0, rows = 0;
    int bitsAllocated = 16, bitsStored = 16, highBit = 15;
    bool isSigned = false;
    StreamCoding stream = StreamCoding::jpeg; // compressed only, as the next
    std::vector<Fragment> fragments;
    bool hasOverlayBits = false; // overlays are in bits beside the stored ones
    bool lossy = false;          // by the header, the transfer syntax or the stream's own header
    double lossyRatio = 0;       // LossyImageCompressionRatio; 0 unknown
    std::optional<std::int32_t> largestStored;               // LargestImagePixelValue
    std::optional<double> slope, intercept;                  // absent: not rescaled
    std::optional<std::int32_t> paddingFirst, paddingLast;   // stored values, inclusive; both or none
    std::optional<glm::dvec3> positionMm;                    // ImagePositionPatient
    std::optional<glm::dvec3> rowDirection, columnDirection; // along a row (x), along a column (y)
    std::optional<glm::dvec2> spacingMm;                     // x, y
    std::string
        irregularity; // irregularity of the file's structure, in words that quote no value; empty: none
    SliceMoment moment;
    std::string kernel;                        // a code word; "" unknown
    double tubeVoltageKv = 0, thicknessMm = 0; // 0 unknown
    std::optional<int> instance;               // InstanceNumber; says nothing about the order
    double suvPerValue = 0;                    // PET: SUV by body weight; 0 unknown
    std::optional<HeaderFault> fault;          // the first invalid number of the header
};

struct DicomSeries {
    std::vector<DicomSlice> slices; // in the order of the files' names
    Acquisition acquisition;
    bool isHounsfield = false;         // CT, rescaled, with no other unit stated
    std::string frameOfReference;      // UID of all slices that state one; "" unknown, or one a slice
    double betweenSlicesMm = 0;        // SpacingBetweenSlices, 0 unknown; used for a single slice only
    bool isScout = false;              // a localizer: a projection, not a section
    std::string object;                // kind of an object other than CT, MR or PET: "secondary capture"
    std::string disagreement;          // an element that must be the same in every file and is not
    std::vector<std::string> oddities; // harmless irregularities
    std::string derivation;            // "MPR", "MIP", ...: its derivation, "" for an original
    std::string part;                  // part of a split series: "frame of reference 1 of 2"; "" all of it
    std::optional<int> number;         // SeriesNumber
    std::string suvMissing;            // PET: why SUV is unknown
    std::string date;                  // "2023-05-17", for the choice, never stored; "" unknown
};

/// Files of one series without slices of a volume, and their kind.
struct DicomOther {
    std::string modality, what; // "SR", "dose report"
    int files = 0;
};

struct DicomScan {
    std::vector<DicomSeries> series; // by the name of their first file; each has a slice with a position
    std::vector<DicomOther> others;
    std::vector<PassedFile> passed; // every file in no series
};

/// Reads the headers of these files, no pixels. Every file is in a series or among the skipped ones.
DicomScan scanDicom(const std::vector<std::filesystem::path>& files);

} // namespace tessera
