// bricking/import/labels/seg/seg_object.cpp: see seg_object.h. DICOM PS3.3, A.51 and C.8.20. DCMTK reads the
// elements. Its dcmseg of 3.6.7 is not used: it holds all frames in memory and does not know label maps.
#include "bricking/import/labels/seg/seg_object.h"

#include "bricking/import/dicom/dicom_deflated.h"
#include "bricking/import/dicom/dicom_structure.h"
#include "bricking/import/dicom/items/dicom_items.h"
#include "bricking/import/labels/seg/seg_colour.h"
#include "bricking/import/source/source_files.h"
#include "core/base/dicom_uid.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>
#include <string_view>

namespace tessera {
namespace {

constexpr std::string_view kSegmentation = "1.2.840.10008.5.1.4.1.1.66.4",
                           kSurfaces = "1.2.840.10008.5.1.4.1.1.66.5",
                           kLabelmap = "1.2.840.10008.5.1.4.1.1.66.7";
constexpr double kSameDirection = 1e-4; // of components
constexpr double kSameSpacing = 1e-4;   // of a spacing

struct Syntax {
    std::string_view uid;
    SegCoding coding;
};
constexpr std::array kSyntaxes = {Syntax{"1.2.840.10008.1.2", SegCoding::plain},
                                  Syntax{"1.2.840.10008.1.2.1", SegCoding::plain},
                                  Syntax{kDeflatedSyntax, SegCoding::plain},
                                  Syntax{"1.2.840.10008.1.2.1.98", SegCoding::framesPlain},
                                  Syntax{"1.2.840.10008.1.2.5", SegCoding::rle},
                                  Syntax{"1.2.840.10008.1.2.4.57", SegCoding::jpeg},
                                  Syntax{"1.2.840.10008.1.2.4.70", SegCoding::jpeg},
                                  Syntax{"1.2.840.10008.1.2.4.80", SegCoding::jpegLs},
                                  Syntax{"1.2.840.10008.1.2.4.90", SegCoding::jpeg2000}};

class SegReader {
  public:
    explicit SegReader(const std::filesystem::path& file) : where_(file.string()) { seg_.file = file; }

    SegObject read() {
        silenceDcmtk();
        DicomStructure structure = structureOf(seg_.file);
        const std::string syntax = structure.syntax;
        std::optional<InflatedFile> inflated;
        seg_.isDeflated = syntax == kDeflatedSyntax;
        if (seg_.isDeflated) {
            inflated.emplace(seg_.file);
            structure = structureOf(inflated->path());
            if (structure.pixelOffsetBytes > kMostInflatedHeader)
                throw badFile(where_, "pixels that begin within 16 MiB of a deflated data set", "none there");
        }
        const std::uint64_t bytes = inflated ? inflated->sizeBytes() : InputFile(seg_.file).sizeBytes();
        if (structure.breaksOff)
            throw badFile(where_, "a whole DICOM file", structure.irregularity + " (is it truncated?)");
        if (!structure.irregularity.empty())
            seg_.notes.push_back("the file is irregular: " + structure.irregularity);
        seg_.pixelOffsetBytes = structure.pixelOffsetBytes;
        const auto* const coding = std::find_if(kSyntaxes.begin(), kSyntaxes.end(), [&](const Syntax& row) {
            return row.uid == (syntax.empty() ? kSyntaxes[0].uid : syntax);
        });
        if (coding == kSyntaxes.end())
            throw badFile(where_,
                          "a segmentation that is not compressed, deflated, or compressed without loss",
                          "transfer syntax " + printable(syntax));
        seg_.coding = coding->coding;

        // Long elements stay in the file: the pixels are not read here.
        constexpr Uint32 kMostKept = 4096;
        DcmFileFormat format;
        if (const OFCondition result = format.loadFile((inflated ? inflated->path() : where_).c_str(),
                                                       EXS_Unknown, EGL_noChange, kMostKept);
            result.bad())
            throw badFile(where_, "a DICOM file", "a header that cannot be read");
        DcmDataset& data = *format.getDataset();
        requireKind(data);
        readShape(data);
        readSegments(data);
        readFrames(data);
        checkPixels(data, bytes);
        seg_.frameOfReference = uidOrNone(itemText(data, DCM_FrameOfReferenceUID));
        return std::move(seg_);
    }

  private:
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(where_, expected, found);
    }

    void requireKind(DcmDataset& data) {
        const std::string storage = itemText(data, DCM_SOPClassUID);
        if (storage == kSurfaces)
            refuse("a segmentation of pixels", "a segmentation of surfaces");
        if (storage != kSegmentation && storage != kLabelmap)
            refuse("a DICOM Segmentation (SOPClassUID)", "another object");
        const std::string type = itemText(data, DCM_SegmentationType);
        if (type == "BINARY")
            seg_.kind = SegKind::binary;
        else if (type == "FRACTIONAL")
            seg_.kind = SegKind::fractional;
        else if (type == "LABELMAP")
            seg_.kind = SegKind::labelmap;
        else
            refuse("SegmentationType (0062,0001) BINARY, FRACTIONAL or LABELMAP", "another");
    }

    void readShape(DcmDataset& data) {
        const auto required = [&](const DcmTagKey& tag, const char* name) {
            const auto value = itemNumber(data, tag);
            if (!value)
                refuse(std::string(name), "none");
            return static_cast<int>(*value);
        };
        seg_.rows = required(DCM_Rows, "Rows (0028,0010)");
        seg_.columns = required(DCM_Columns, "Columns (0028,0011)");
        seg_.bitsAllocated = required(DCM_BitsAllocated, "BitsAllocated (0028,0100)");
        if (seg_.rows < 1 || seg_.columns < 1)
            refuse("Rows and Columns of at least 1",
                   std::to_string(seg_.rows) + " and " + std::to_string(seg_.columns));
        const bool isByte = seg_.bitsAllocated == 8;
        const bool fits = seg_.kind == SegKind::binary       ? isByte || seg_.bitsAllocated == 1
                          : seg_.kind == SegKind::fractional ? isByte
                                                             : isByte || seg_.bitsAllocated == 16;
        if (!fits)
            refuse("BitsAllocated (0028,0100) of 1 (BINARY), 8 (FRACTIONAL), or 8 or 16 (LABELMAP)",
                   std::to_string(seg_.bitsAllocated));
        if (itemNumber(data, DCM_SamplesPerPixel).value_or(1) != 1 ||
            itemNumber(data, DCM_PixelRepresentation).value_or(0) != 0)
            refuse("one value without a sign a pixel", "SamplesPerPixel or PixelRepresentation of another");
        if (seg_.bitsAllocated == 1 && seg_.coding != SegCoding::plain &&
            seg_.coding != SegCoding::framesPlain)
            refuse("pixels of one bit that are not compressed", "a compression of whole bytes");
        if (seg_.kind == SegKind::fractional)
            readFraction(data);
        if (seg_.kind == SegKind::labelmap)
            seg_.padding = itemNumber(data, DCM_PixelPaddingValue);
    }

    void readFraction(DcmDataset& data) {
        const auto most = itemNumber(data, DCM_MaximumFractionalValue);
        if (!most || *most < 1 || *most > 255)
            refuse("MaximumFractionalValue (0062,000e) from 1 to 255", most ? std::to_string(*most) : "none");
        seg_.halfValue = (*most + 1) / 2;
        const std::string type = itemText(data, DCM_SegmentationFractionalType);
        seg_.notes.push_back(std::string("a fractional segmentation") +
                             (type == "PROBABILITY" ? " (probability)"
                              : type == "OCCUPANCY" ? " (occupancy)"
                                                    : "") +
                             ": inside is where it has at least half of its maximum");
    }

    void readSegments(DcmDataset& data) {
        DcmSequenceOfItems* sequence = nullptr;
        if (data.findAndGetSequence(DCM_SegmentSequence, sequence).bad() || sequence->card() == 0)
            refuse("a SegmentSequence (0062,0002)", "none");
        const std::string characters = itemText(data, DCM_SpecificCharacterSet);
        std::set<std::uint32_t> numbers;
        for (DcmObject* at = nullptr; (at = sequence->nextInContainer(at)) != nullptr;) {
            DcmItem& item = *static_cast<DcmItem*>(at);
            const auto number = itemNumber(item, DCM_SegmentNumber);
            const bool isBackground = seg_.kind == SegKind::labelmap && number == 0u;
            if (!number || (*number == 0 && !isBackground))
                refuse("SegmentNumber (0062,0004) of at least 1 in every segment",
                       number ? std::to_string(*number) : "none");
            if (!numbers.insert(*number).second)
                refuse("segments of different numbers", "several of number " + std::to_string(*number));
            if (isBackground)
                continue;
            Label label{*number, itemWords(item, DCM_SegmentLabel, characters)};
            if (label.name.empty())
                label.name = "label " + std::to_string(*number);
            if (DcmItem* category = firstItem(item, DCM_SegmentedPropertyCategoryCodeSequence))
                label.group = itemWords(*category, DCM_CodeMeaning, characters);
            const auto l = itemNumber(item, DCM_RecommendedDisplayCIELabValue, 0),
                       a = itemNumber(item, DCM_RecommendedDisplayCIELabValue, 1),
                       b = itemNumber(item, DCM_RecommendedDisplayCIELabValue, 2);
            if (l && a && b)
                label.colour = linearFromDicomLab(*l, *a, *b);
            seg_.segments.push_back(std::move(label));
        }
        std::sort(seg_.segments.begin(), seg_.segments.end(),
                  [](const Label& a, const Label& b) { return a.value < b.value; });
    }

    void readFrames(DcmDataset& data) {
        const std::string frames = itemText(data, DCM_NumberOfFrames);
        DcmSequenceOfItems* sequence = nullptr;
        if (data.findAndGetSequence(DCM_PerFrameFunctionalGroupsSequence, sequence).bad() ||
            sequence->card() == 0)
            refuse("a PerFrameFunctionalGroupsSequence (5200,9230)", "none");
        if (!frames.empty() && frames != std::to_string(sequence->card()))
            refuse("NumberOfFrames (0028,0008) items in PerFrameFunctionalGroupsSequence (5200,9230)",
                   std::to_string(sequence->card()) + " items");
        DcmItem* const shared = firstItem(data, DCM_SharedFunctionalGroupsSequence);
        for (DcmObject* at = nullptr; (at = sequence->nextInContainer(at)) != nullptr;) {
            DcmItem& own = *static_cast<DcmItem*>(at);
            const auto group = [&](const DcmTagKey& tag) {
                DcmItem* const found = firstItem(own, tag);
                return found || !shared ? found : firstItem(*shared, tag);
            };
            readFrame(group);
        }
    }

    std::string frameName() const { return "frame " + std::to_string(seg_.frames.size() + 1); }

    template <class Group> void readFrame(const Group& group) {
        SegFrame frame;
        DcmItem* const plane = group(DCM_PlanePositionSequence);
        const auto position =
            plane ? itemReals(*plane, DCM_ImagePositionPatient, 3, "ImagePositionPatient (0020,0032)", where_)
                  : std::nullopt;
        if (!position)
            refuse("ImagePositionPatient (0020,0032) in the PlanePositionSequence of every frame",
                   "none for " + frameName());
        frame.positionMm = {(*position)[0], (*position)[1], (*position)[2]};
        readOrientation(group(DCM_PlaneOrientationSequence));
        readMeasures(group(DCM_PixelMeasuresSequence));
        if (seg_.kind != SegKind::labelmap) {
            DcmItem* const item = group(DCM_SegmentIdentificationSequence);
            const auto number = item ? itemNumber(*item, DCM_ReferencedSegmentNumber) : std::nullopt;
            const auto isIt = [&](const Label& label) { return number == label.value; };
            if (std::none_of(seg_.segments.begin(), seg_.segments.end(), isIt))
                refuse("ReferencedSegmentNumber (0062,000b) of a segment in every frame",
                       (number ? std::to_string(*number) : "none") + std::string(" for ") + frameName());
            frame.segment = *number;
        }
        seg_.frames.push_back(frame);
    }

    void readOrientation(DcmItem* item) {
        const auto six = item ? itemReals(*item, DCM_ImageOrientationPatient, 6,
                                          "ImageOrientationPatient (0020,0037)", where_)
                              : std::nullopt;
        if (!six)
            refuse("ImageOrientationPatient (0020,0037) for every frame", "none for " + frameName());
        const glm::dvec3 row((*six)[0], (*six)[1], (*six)[2]), column((*six)[3], (*six)[4], (*six)[5]);
        constexpr double kMostError = 0.01; // of lengths and of the right angle
        if (std::abs(glm::length(row) - 1) > kMostError || std::abs(glm::length(column) - 1) > kMostError ||
            std::abs(glm::dot(row, column)) > kMostError)
            refuse("ImageOrientationPatient (0020,0037) of two perpendicular unit vectors",
                   "others for " + frameName());
        const glm::dvec3 unitRow = glm::normalize(row), unitColumn = glm::normalize(column);
        if (seg_.frames.empty()) {
            seg_.rowDirection = unitRow;
            seg_.columnDirection = unitColumn;
        } else if (glm::length(unitRow - seg_.rowDirection) > kSameDirection ||
                   glm::length(unitColumn - seg_.columnDirection) > kSameDirection) {
            refuse("frames of one orientation", "another one for " + frameName());
        }
    }

    void readMeasures(DcmItem* item) {
        const auto spacing =
            item ? itemReals(*item, DCM_PixelSpacing, 2, "PixelSpacing (0028,0030)", where_) : std::nullopt;
        if (!spacing)
            refuse("PixelSpacing (0028,0030) for every frame", "none for " + frameName());
        const glm::dvec2 xy((*spacing)[1], (*spacing)[0]); // the file has the distance of rows first
        if (!(xy.x > 0 && xy.y > 0))
            refuse("PixelSpacing (0028,0030) above 0", "another for " + frameName());
        if (seg_.frames.empty()) {
            seg_.spacingMm = xy;
            const auto one = [&](const DcmTagKey& tag, const char* name) {
                const auto value = itemReals(*item, tag, 1, name, where_);
                return value ? std::max(0.0, value->front()) : 0.0;
            };
            seg_.betweenSlicesMm = one(DCM_SpacingBetweenSlices, "SpacingBetweenSlices (0018,0088)");
            seg_.thicknessMm = one(DCM_SliceThickness, "SliceThickness (0018,0050)");
        } else if (std::abs(xy.x - seg_.spacingMm.x) > kSameSpacing * seg_.spacingMm.x ||
                   std::abs(xy.y - seg_.spacingMm.y) > kSameSpacing * seg_.spacingMm.y) {
            refuse("frames of one PixelSpacing (0028,0030)", "another one for " + frameName());
        }
    }

    /// Of pixels that are not compressed the length is known; frames of compressed ones are checked one by
    /// one.
    void checkPixels(DcmDataset& data, std::uint64_t fileBytes) {
        DcmElement* pixels = nullptr;
        if (data.findAndGetElement(DCM_PixelData, pixels).bad() || seg_.pixelOffsetBytes == 0)
            refuse("PixelData (7fe0,0010)", "none");
        if (seg_.coding != SegCoding::plain)
            return;
        const std::uint64_t bits = seg_.frames.size() * static_cast<std::uint64_t>(seg_.rows) *
                                   static_cast<std::uint64_t>(seg_.columns) *
                                   static_cast<std::uint64_t>(seg_.bitsAllocated);
        const std::uint64_t needed = (bits + 7) / 8, found = pixels->getLengthField();
        const bool isThere = found <= fileBytes && seg_.pixelOffsetBytes <= fileBytes - found;
        if (!isThere || found < needed || found > needed + 1)
            refuse(std::to_string(needed) + " bytes of PixelData (7fe0,0010) for " +
                       std::to_string(seg_.frames.size()) + " frames of " + std::to_string(seg_.columns) +
                       " x " + std::to_string(seg_.rows),
                   isThere ? std::to_string(found) : "more than the file has");
    }

    SegObject seg_;
    std::string where_;
};

} // namespace

bool isSegmentation(const std::filesystem::path& file) {
    const std::string storage = storageClassOf(file);
    return storage == kSegmentation || storage == kSurfaces || storage == kLabelmap;
}

SegObject readSegObject(const std::filesystem::path& file) {
    return SegReader(file).read();
}

} // namespace tessera
