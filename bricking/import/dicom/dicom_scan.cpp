// bricking/import/dicom/dicom_scan.cpp: see dicom_scan.h. The headers are parsed by vtk-dicom.
#include "bricking/import/dicom/dicom_scan.h"

#include "bricking/import/dicom/dicom_deflated.h"
#include "bricking/import/dicom/dicom_header.h"
#include "bricking/import/dicom/dicom_remarks.h"
#include "bricking/import/dicom/dicom_structure.h"
#include "bricking/import/dicom/folder_walk.h"
#include "bricking/import/dicom/series_parts.h"
#include "bricking/import/source/source_files.h"
#include "core/base/dicom_uid.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vtkDICOMDictionary.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMParser.h>
#include <vtkNew.h>

namespace tessera {
namespace {

constexpr int kMostFrames = 65536;
constexpr const char* kSecondaryCapture = "1.2.840.10008.5.1.4.1.1.7"; // and its multi-frame kinds
constexpr const char* kScoutMark = "|scout";                           // no UID has it

constexpr const char* kImplicitLittle = "1.2.840.10008.1.2";
constexpr const char* kExplicitLittle = "1.2.840.10008.1.2.1";
constexpr const char* kExplicitBig = "1.2.840.10008.1.2.2";
/// The compressed transfer syntaxes that are opened. The stream's own header says which process it is.
struct CompressedSyntax {
    const char* uid;
    StreamCoding coding;
    bool lossyAlways;
};
constexpr std::array<CompressedSyntax, 11> kCompressed = {{
    {"1.2.840.10008.1.2.5", StreamCoding::rle, false},
    {"1.2.840.10008.1.2.4.50", StreamCoding::jpeg, true},  // baseline, 8 bits
    {"1.2.840.10008.1.2.4.51", StreamCoding::jpeg, true},  // extended, 8 and 12 bits
    {"1.2.840.10008.1.2.4.53", StreamCoding::jpeg, true},  // spectral selection
    {"1.2.840.10008.1.2.4.55", StreamCoding::jpeg, true},  // full progression
    {"1.2.840.10008.1.2.4.57", StreamCoding::jpeg, false}, // lossless
    {"1.2.840.10008.1.2.4.70", StreamCoding::jpeg, false}, // lossless, first-order prediction
    {"1.2.840.10008.1.2.4.80", StreamCoding::jpegLs, false},
    {"1.2.840.10008.1.2.4.81", StreamCoding::jpegLs, false}, // near-lossless, of any nearness
    {"1.2.840.10008.1.2.4.90", StreamCoding::jpeg2000, false},
    {"1.2.840.10008.1.2.4.91", StreamCoding::jpeg2000, false}, // reversible or not
}};
constexpr std::size_t kPeekBytes = 4096; // a stream's own header lies at its beginning

const CompressedSyntax* compressedSyntax(const std::string& uid) {
    const auto at = std::find_if(kCompressed.begin(), kCompressed.end(),
                                 [&](const CompressedSyntax& syntax) { return uid == syntax.uid; });
    return at == kCompressed.end() ? nullptr : &*at;
}

template <class List> bool contains(const List& list, const std::string& word) {
    return std::any_of(list.begin(), list.end(), [&](const char* item) { return word == item; });
}

using Header = DicomHeader;

/// The pixels' description must be whole; a parser takes defaults for what is not there.
std::string missingTag(const Header& header) {
    for (const auto& [tag, name] : {std::pair(DC::SamplesPerPixel, "SamplesPerPixel"),
                                    {DC::PhotometricInterpretation, "PhotometricInterpretation"},
                                    {DC::BitsAllocated, "BitsAllocated"},
                                    {DC::BitsStored, "BitsStored"},
                                    {DC::HighBit, "HighBit"},
                                    {DC::PixelRepresentation, "PixelRepresentation"}})
        if (header.text(tag).empty())
            return std::string("no ") + name;
    const int highBit = header.integer(DC::HighBit).value_or(0),
              stored = header.integer(DC::BitsStored).value_or(0);
    if (highBit != stored - 1)
        return "HighBit " + std::to_string(highBit) + " with " + std::to_string(stored) + " bits stored";
    return "";
}

/// Overlays within the pixels' words, as old scanners wrote them: OverlayBitPosition (60xx,0102) is not 0.
bool hasOverlayBits(const Header& header) {
    for (int group = 0x6000; group <= 0x601E; group += 2)
        if (header.integer(vtkDICOMTag(static_cast<unsigned short>(group), 0x0102)).value_or(0) > 0)
            return true;
    return false;
}

/// The stated colour model of one sample per pixel: an index into a table, or a mistake. "": greys.
std::string colourOf(const Header& header) {
    const std::string text = header.text(DC::PhotometricInterpretation);
    for (const char* colour : {"RGB", "PALETTE", "YBR", "HSV", "ARGB", "CMYK"})
        if (text.rfind(colour, 0) == 0)
            return colour;
    return "";
}

/// "2023-05-17", of the series, the acquisition or the study; "" where none is a date.
std::string dateOf(const Header& header) {
    for (const vtkDICOMTag tag :
         {vtkDICOMTag(DC::SeriesDate), vtkDICOMTag(DC::AcquisitionDate), vtkDICOMTag(DC::StudyDate)}) {
        const std::string text = header.text(tag);
        if (text.size() == 8 && text.find_first_not_of("0123456789") == std::string::npos)
            return text.substr(0, 4) + "-" + text.substr(4, 2) + "-" + text.substr(6);
    }
    return "";
}

/// The shape and number format of the pixels. False: an image, but not a slice of scalars.
bool readPixelFormat(const Header& header, DicomSlice& slice) {
    slice.columns = header.integer(DC::Columns).value_or(0);
    slice.rows = header.integer(DC::Rows).value_or(0);
    slice.bitsAllocated = header.integer(DC::BitsAllocated).value_or(0);
    slice.bitsStored = header.integer(DC::BitsStored).value_or(slice.bitsAllocated);
    slice.highBit = header.integer(DC::HighBit).value_or(slice.bitsStored - 1);
    slice.isSigned = header.integer(DC::PixelRepresentation).value_or(0) == 1;
    slice.hasOverlayBits = hasOverlayBits(header);
    slice.lossy = header.text(DC::LossyImageCompression) == "01";
    slice.lossyRatio = std::max(0.0, header.last(DC::LossyImageCompressionRatio).value_or(0));
    slice.largestStored = storedValueOf(header.integer(DC::LargestImagePixelValue), slice);
    return slice.columns > 0 && slice.rows > 0 && header.integer(DC::SamplesPerPixel).value_or(1) == 1 &&
           (slice.bitsAllocated == 8 || slice.bitsAllocated == 16) && slice.bitsStored >= 1 &&
           slice.highBit < slice.bitsAllocated && slice.highBit + 1 >= slice.bitsStored;
}

/// Scans files into series.
class Scanner {
  public:
    void add(const std::filesystem::path& file) {
        const Beginning beginning = beginningOf(file);
        current_ = {};
        switch (beginning.kind) {
        case FileStart::empty:
            return pass({file, PassedReason::empty});
        case FileStart::zeros:
            return pass({file, PassedReason::zeroFilled});
        case FileStart::notReadable:
            return pass({file, PassedReason::notReadable, "", beginning.problem});
        case FileStart::other:
            return pass({file, PassedReason::notDicom});
        case FileStart::dicom:
            break;
        }
        DicomStructure structure = structureOf(file);
        const std::string syntax = structure.syntax;
        std::optional<InflatedFile> inflated;
        if (syntax == kDeflatedSyntax) {
            try {
                inflated.emplace(file);
            } catch (const BadFile& fault) {
                return damaged(file, fault.expected(), fault.found());
            }
            structure = structureOf(inflated->path());
            if (inflated->sizeBytes() > kMostInflatedHeader &&
                (structure.pixelOffsetBytes == 0 || structure.pixelOffsetBytes > kMostInflatedHeader))
                return damaged(file, "pixels that begin within 16 MiB of a deflated data set", "none there");
        }
        if (structure.breaksOff)
            return damaged(file, "a whole DICOM file", structure.irregularity + " (is it truncated?)");
        vtkNew<vtkDICOMMetaData> data;
        vtkNew<vtkDICOMParser> parser;
        parse(*parser, *data, inflated ? inflated->path() : file.string());
        const Header header(data);
        current_ = {header.text(DC::SeriesInstanceUID), modalityOf(header.text(DC::Modality)),
                    header.text(DC::MediaStorageSOPClassUID), parser->GetPixelDataFound()};
        if (current_.storageClass.empty())
            current_.storageClass = header.text(DC::SOPClassUID);
        if (current_.isWhole)
            return addImage(file, structure, header, syntax, *parser);
        // The class is in the meta group: if that is damaged, it is unreliable.
        if (structure.syntax.empty() && !structure.irregularity.empty())
            return damaged(file, "a meta group without fault", structure.irregularity);
        const std::string words = objectWords(current_.storageClass);
        if (!words.empty())
            return pass({file, PassedReason::notImage, "", words});
        // Every other kind should have pixels, or its class is damaged.
        if (current_.storageClass.empty() || isSliceClass(current_.storageClass) ||
            parser->GetErrorCode() != 0 || header.integer(DC::Rows))
            return damaged(file, "a whole DICOM image", "a header that breaks off (is it truncated?)");
        pass({file, PassedReason::notImage, "", "DICOM object without pixels"});
    }

    DicomScan take() {
        // A series in which nothing has a position (a radiograph, a screen shot) is no volume. A series with
        // some positions is kept whole, so that a slice without a position is noticed.
        std::vector<std::optional<std::size_t>> kept; // of each series, its index in `series`
        std::vector<DicomSeries> series;
        joinLoneSlices(scan_.series, says_);
        const bool slicesAreRegular =
            std::all_of(scan_.series.begin(), scan_.series.end(), [](const DicomSeries& each) {
                return std::all_of(each.slices.begin(), each.slices.end(), [](const DicomSlice& slice) {
                    return !slice.positionMm || slice.irregularity.empty();
                });
            });
        for (std::size_t index = 0; index < scan_.series.size(); ++index) {
            DicomSeries& each = scan_.series[index];
            if (each.slices.empty()) { // joined to an earlier one
                kept.push_back(std::nullopt);
                continue;
            }
            const bool placed =
                std::any_of(each.slices.begin(), each.slices.end(),
                            [](const DicomSlice& slice) { return slice.positionMm.has_value(); });
            kept.push_back(placed ? std::optional(series.size()) : std::nullopt);
            if (placed) {
                for (DicomSeries& part : partsOf(std::move(each), says_[index]))
                    series.push_back(std::move(part));
                continue;
            }
            says_[index].judge(each);
            const std::string what =
                each.object.empty() ? "image without a position in the patient" : each.object;
            std::set<std::filesystem::path> files; // frames share one
            for (const DicomSlice& slice : each.slices)
                files.insert(slice.file);
            // If the series' UID is missing too, or the header is irregular, it is damaged: it could be a
            // slice of any series.
            const auto irregular =
                std::find_if(each.slices.begin(), each.slices.end(),
                             [](const DicomSlice& slice) { return !slice.irregularity.empty(); });
            const bool isWithoutUid = withoutUid_.contains(index);
            // An irregular header may be wrong about its kind, unless its writer is always irregular.
            const bool isIrregular =
                irregular != each.slices.end() && (each.object.empty() || slicesAreRegular);
            const bool isDamaged = isIrregular || (isWithoutUid && each.object.empty());
            const std::string found = isWithoutUid ? "neither" : isDamaged ? irregular->irregularity : "";
            for (const auto& file : files)
                scan_.passed.push_back(isDamaged ? PassedFile{file, PassedReason::damaged,
                                                              "ImagePositionPatient (0020,0032) and "
                                                              "SeriesInstanceUID (0020,000e)",
                                                              found}
                                                 : PassedFile{file, PassedReason::noPlace, "", what});
            if (!files.empty())
                scan_.others.push_back({each.acquisition.modality, what, static_cast<int>(files.size())});
        }
        for (DicomSeries& each : series)
            takeCommonAcquisition(each);
        scan_.series = std::move(series);
        std::map<std::pair<std::string, std::string>, DicomOther> others;
        for (auto& [file, from] : passed_) {
            const auto known = indexOfUid_.find(from.uid);
            const auto scout = indexOfUid_.find(from.uid + kScoutMark);
            const auto at = known != indexOfUid_.end() ? known : scout;
            if (!from.uid.empty() && at != indexOfUid_.end())
                file.series = kept[at->second];
            file.seriesIsAnother = from.isWhole && !from.uid.empty() && !file.series;
            const bool isDamaged = file.reason == PassedReason::damaged;
            if (!file.series && (isDamaged || !file.found.empty()) && !from.storageClass.empty()) {
                const std::string what =
                    isDamaged ? "damaged or not decodable (" + file.found + ")" : file.found;
                DicomOther& other = others[{from.uid, what}];
                other = {from.modality, what, other.files + 1};
            }
            scan_.passed.push_back(std::move(file));
        }
        for (auto& [key, other] : others)
            scan_.others.push_back(std::move(other));
        return std::move(scan_);
    }

  private:
    static void parse(vtkDICOMParser& parser, vtkDICOMMetaData& data, const std::string& file) {
        parser.SetMetaData(&data);
        parser.SetFileName(file.c_str());
        parser.Update();
    }

    /// Of the current file. The UID identifies a study: it is not passed on.
    struct Current {
        std::string uid, modality, storageClass;
        bool isWhole = false; // the header was read to its end
    };

    void pass(PassedFile file) { passed_.emplace_back(std::move(file), current_); }
    void damaged(const std::filesystem::path& file, std::string expected, std::string found) {
        pass({file, PassedReason::damaged, std::move(expected), std::move(found)});
    }
    /// An image whose pixels are not single values of 8 or 16 bits.
    void notASlice(const std::filesystem::path& file, const Header& header, const DicomSlice& slice) {
        const int samples = header.integer(DC::SamplesPerPixel).value_or(1);
        if (isSliceClass(current_.storageClass) && samples != 1)
            return damaged(file, "SamplesPerPixel (0028,0002) of 1", std::to_string(samples));
        if (isSliceClass(current_.storageClass))
            return damaged(file, "rows and columns of 8 or 16 bits allocated, the stored bits within",
                           std::to_string(slice.rows) + " x " + std::to_string(slice.columns) + ", " +
                               std::to_string(slice.bitsAllocated) + " allocated, " +
                               std::to_string(slice.bitsStored) + " stored");
        const std::string words = objectWords(current_.storageClass);
        pass({file, PassedReason::noPlace, "",
              words.empty() ? std::string(samples > 1 ? "colour image" : "image not of single values")
                            : words});
    }

    void addImage(const std::filesystem::path& file, const DicomStructure& structure, const Header& header,
                  const std::string& syntax, vtkDICOMParser& parser) {
        DicomSlice slice;
        slice.file = file;
        const int frames = std::max(1, header.integer(DC::NumberOfFrames).value_or(1));
        if (!readPixelFormat(header, slice))
            return structure.irregularity.empty()
                       ? notASlice(file, header, slice)
                       : damaged(file, "a header without fault", structure.irregularity);
        if (const std::string colour = colourOf(header); !colour.empty())
            return isSliceClass(current_.storageClass)
                       ? damaged(file,
                                 "PhotometricInterpretation (0028,0004) MONOCHROME1 or MONOCHROME2 for one "
                                 "sample a pixel",
                                 colour)
                       : pass({file, PassedReason::noPlace, "", "colour image"});
        const bool plain = syntax.empty() || syntax == kDeflatedSyntax || syntax == kImplicitLittle ||
                           syntax == kExplicitLittle || (syntax == kExplicitBig && slice.bitsAllocated == 16);
        const CompressedSyntax* const compressed = plain ? nullptr : compressedSyntax(syntax);
        if (!plain && !compressed)
            return damaged(file, "a transfer syntax that can be decoded",
                           "transfer syntax " + codeUid(syntax));
        slice.coding = compressed                  ? PixelCoding::compressed
                       : syntax == kExplicitBig    ? PixelCoding::bigEndian
                       : syntax == kDeflatedSyntax ? PixelCoding::deflated
                                                   : PixelCoding::littleEndian;
        if (header.has(DC::ModalityLUTSequence))
            return damaged(file, "values by RescaleSlope and RescaleIntercept",
                           "a table, ModalityLUTSequence (0028,3000)");
        if (frames > kMostFrames)
            return damaged(file, "at most 65536 frames", std::to_string(frames));
        const std::uint64_t frameBytes = static_cast<std::uint64_t>(slice.columns) *
                                         static_cast<std::uint64_t>(slice.rows) *
                                         static_cast<std::uint64_t>(slice.bitsAllocated / 8);
        const auto offset = static_cast<std::uint64_t>(parser.GetFileOffset());
        const auto fileBytes = static_cast<std::uint64_t>(parser.GetFileSize());
        const std::uint64_t present = std::min<std::uint64_t>(fileBytes - std::min(offset, fileBytes),
                                                              plain ? parser.GetPixelDataVL() : fileBytes);
        const std::uint64_t needed = plain ? frameBytes * static_cast<std::uint64_t>(frames) : 1;
        // No codec here gains more than a thousandfold; a larger stated size is not worth allocating.
        if (present < needed || frameBytes > present * 1000 + (std::uint64_t{1} << 26))
            return damaged(file, std::to_string(plain ? needed : frameBytes) + " bytes of pixels",
                           std::to_string(present) + " bytes (is the file truncated?)");
        std::vector<std::vector<Fragment>> fragments;
        if (compressed) {
            try {
                fragments = findStreams(file, *compressed, offset, frames, slice);
            } catch (const BadFile& fault) {
                return damaged(file, fault.expected(), fault.found());
            }
        }

        slice.irregularity = structure.irregularity;
        if (slice.irregularity.empty() && structure.pixelOffsetBytes != offset)
            slice.irregularity = "pixels at two places";
        if (slice.irregularity.empty())
            slice.irregularity = missingTag(header);

        // More pixels than rows, columns and frames state: one of them is wrong, or a slice is lost.
        const std::uint64_t rowBytes = frameBytes / static_cast<std::uint64_t>(slice.rows);
        if (plain && present >= needed + rowBytes)
            return damaged(file,
                           std::to_string(needed) +
                               " bytes of pixels, as Rows (0028,0010), Columns (0028,0011) "
                               "and NumberOfFrames (0028,0008) say",
                           std::to_string(present));
        if (const std::uint64_t claimed = parser.GetPixelDataVL(); plain && claimed > fileBytes - offset)
            return damaged(file,
                           "the " + std::to_string(claimed) + " bytes that PixelData (7fe0,0010) states",
                           std::to_string(fileBytes - offset));
        // A dose or protocol screen that was saved under the scan's own SeriesInstanceUID is no slice of it.
        if (!header.has(DC::ImagePositionPatient) && frames == 1 &&
            current_.storageClass.rfind(kSecondaryCapture, 0) == 0)
            return pass({file, PassedReason::noPlace, "", "secondary capture"});

        std::vector<DicomSlice> slices;
        for (int frame = 0; frame < frames; ++frame) {
            readPlace(header, frame, slice);
            if (slice.fault)
                return damaged(file, slice.fault->expected, slice.fault->found);
            slice.pixelOffsetBytes = offset + static_cast<std::uint64_t>(frame) * frameBytes;
            if (compressed)
                slice.fragments = std::move(fragments[static_cast<std::size_t>(frame)]);
            slices.push_back(slice);
        }
        const SuvFactor suv =
            current_.modality == "PT" ? suvFactorOf(header) : SuvFactor(); // of all frames alike
        const std::size_t index = seriesOf(header, slices.front());
        if (scan_.series[index].suvMissing.empty())
            scan_.series[index].suvMissing = suv.missing;
        const SliceSays says = {header.text(DC::Modality), header.text(DC::RescaleType),
                                header.text(DC::PatientID), header.text(DC::FrameOfReferenceUID),
                                slices.front().intercept.has_value()};
        for (DicomSlice& each : slices) {
            each.suvPerValue = suv.perValue;
            scan_.series[index].slices.push_back(std::move(each));
            says_[index].add(says);
        }
    }

    /// The fragments of each frame; loss by the first stream's own header goes to slice.
    static std::vector<std::vector<Fragment>> findStreams(const std::filesystem::path& path,
                                                          const CompressedSyntax& syntax,
                                                          std::uint64_t offset, int frames,
                                                          DicomSlice& slice) {
        const InputFile file(path);
        auto found = framesOf(file, offset, frames);
        slice.stream = syntax.coding;
        std::vector<std::byte> beginning(
            std::min<std::size_t>(kPeekBytes, found.front().front().lengthBytes));
        file.readAt(found.front().front().offsetBytes, beginning);
        const auto header = peekHeader(syntax.coding, beginning);
        slice.lossy = slice.lossy || syntax.lossyAlways || (header && header->lossy);
        return found;
    }

    /// Only UID characters reach a message.
    static std::string codeUid(const std::string& uid) {
        return uid.empty() || isDicomUid(uid) ? uid : "(not a UID)";
    }

    /// The substitute for a missing series, as some anonymisers leave it.
    static std::string withoutUid(const Header& header, const DicomSlice& slice) {
        std::string key = "|" + header.text(DC::StudyInstanceUID) + "|" + header.text(DC::SeriesNumber) +
                          "|" + std::to_string(slice.columns) + "|" + std::to_string(slice.rows);
        for (const auto& direction : {slice.rowDirection, slice.columnDirection})
            for (int axis = 0; direction && axis < 3; ++axis)
                key += "|" + std::to_string(std::lround(10 * (*direction)[axis]));
        return key;
    }

    /// The index of the series that a file belongs to.
    std::size_t seriesOf(const Header& header, const DicomSlice& slice) {
        // A scout beside sections of its own series is a series of its own.
        const std::string imageType = header.text(DC::ImageType);
        const bool isScout = hasType(imageType, "LOCALIZER");
        const std::string uid = current_.uid.empty() ? withoutUid(header, slice) : current_.uid;
        const auto [at, isNew] =
            indexOfUid_.try_emplace(uid + (isScout ? kScoutMark : ""), scan_.series.size());
        if (!isNew)
            return at->second;
        DicomSeries series;
        series.isScout = isScout;
        series.object = objectWords(current_.storageClass);
        series.derivation = derivationOf(imageType);
        series.betweenSlicesMm = std::abs(header.real(DC::SpacingBetweenSlices).value_or(0));
        series.number = header.integer(DC::SeriesNumber);
        series.date = dateOf(header);
        if (current_.uid.empty()) {
            withoutUid_.insert(at->second);
            series.oddities.push_back(
                "no SeriesInstanceUID (0020,000e): slices of one study, number, size and "
                "orientation are taken for one series");
        }
        scan_.series.push_back(std::move(series));
        says_.emplace_back();
        return at->second;
    }

    DicomScan scan_;
    Current current_;
    std::vector<std::pair<PassedFile, Current>> passed_;
    std::vector<SeriesAgreement> says_;             // of each series
    std::set<std::size_t> withoutUid_;              // series that no file names
    std::map<std::string, std::size_t> indexOfUid_; // a UID identifies a study: it is not passed on
};

} // namespace

DicomScan scanDicom(const std::vector<std::filesystem::path>& files) {
    const QuietVtk quiet;
    Scanner scanner;
    for (const auto& file : files) {
        checkInterrupted();
        scanner.add(file);
    }
    return scanner.take();
}

} // namespace tessera
