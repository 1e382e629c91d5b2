// bricking/import/dicom_scan.cpp: see dicom_scan.h. The headers are parsed by vtk-dicom.
#include "bricking/import/dicom_scan.h"

#include "bricking/import/dicom_deflated.h"
#include "bricking/import/dicom_structure.h"
#include "bricking/import/input_file.h"
#include "bricking/import/vtk_quiet.h"
#include "core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <sys/mman.h> // memfd_create
#include <unistd.h>
#include <vtkDICOMDictionary.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMParser.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

namespace tessera {
namespace {

constexpr int kMostFrames = 65536;

// Storage classes whose every file should be a readable slice: CT, enhanced CT, legacy converted CT, MR,
// enhanced MR, legacy converted MR, PET, enhanced PET, cone-beam CT.
constexpr std::array kSliceClasses = {
    "1.2.840.10008.5.1.4.1.1.2",   "1.2.840.10008.5.1.4.1.1.2.1", "1.2.840.10008.5.1.4.1.1.2.2",
    "1.2.840.10008.5.1.4.1.1.4",   "1.2.840.10008.5.1.4.1.1.4.1", "1.2.840.10008.5.1.4.1.1.4.4",
    "1.2.840.10008.5.1.4.1.1.128", "1.2.840.10008.5.1.4.1.1.130", "1.2.840.10008.5.1.4.1.1.13.1.1"};

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

/// A header of one file, asked per frame: the functional groups of multi-frame files come before the top
/// level.
class Header {
  public:
    explicit Header(vtkDICOMMetaData* data) : data_(data) {}

    std::string text(vtkDICOMTag tag) const {
        std::string value = data_->Get(0, 0, tag).AsString();
        while (!value.empty() && (value.back() == ' ' || value.back() == '\0'))
            value.pop_back();
        return value;
    }
    std::optional<int> integer(vtkDICOMTag tag, int frame = 0) const {
        const vtkDICOMValue& value = data_->Get(0, frame, tag);
        if (!value.IsValid() || value.GetNumberOfValues() < 1)
            return std::nullopt;
        return value.AsInt();
    }
    /// Exactly N finite numbers, or nothing.
    template <int N> std::optional<std::array<double, N>> reals(vtkDICOMTag tag, int frame) const {
        const vtkDICOMValue& value = data_->Get(0, frame, tag);
        if (!value.IsValid() || value.GetNumberOfValues() != N)
            return std::nullopt;
        std::array<double, N> out{};
        for (std::size_t i = 0; i < N; ++i) {
            out[i] = value.GetDouble(i);
            if (!std::isfinite(out[i]))
                return std::nullopt;
        }
        return out;
    }
    std::optional<double> real(vtkDICOMTag tag, int frame = 0) const {
        const auto value = reals<1>(tag, frame);
        return value ? std::optional((*value)[0]) : std::nullopt;
    }

    /// The last of several numbers: what was done last.
    std::optional<double> last(vtkDICOMTag tag) const {
        const vtkDICOMValue& value = data_->Get(0, 0, tag);
        if (!value.IsValid() || value.GetNumberOfValues() < 1)
            return std::nullopt;
        const double number = value.GetDouble(value.GetNumberOfValues() - 1);
        return std::isfinite(number) ? std::optional(number) : std::nullopt;
    }

  private:
    vtkDICOMMetaData* data_;
};

/// Short code words only: what a whitelist entry may hold. Anything else is dropped, not shortened.
std::string codeWord(const std::string& text) {
    const auto plain = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
               std::strchr("+-_./\\ ", c) != nullptr;
    };
    return text.size() <= 16 && std::all_of(text.begin(), text.end(), plain) ? text : "";
}

/// Tags of stored values (padding, extremes): whether they are signed follows the pixels, whatever the file's
/// own coding says.
std::optional<std::int32_t> storedValueOf(std::optional<int> value, const DicomSlice& slice) {
    if (!value)
        return std::nullopt;
    const int bits = *value & 0xffff;
    return slice.isSigned && bits >= 0x8000 ? bits - 0x10000 : bits;
}

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
    slice.lossy = header.text(DC::LossyImageCompression) == "01";
    slice.lossyRatio = std::max(0.0, header.last(DC::LossyImageCompressionRatio).value_or(0));
    slice.largestStored = storedValueOf(header.integer(DC::LargestImagePixelValue), slice);
    return slice.columns > 0 && slice.rows > 0 && header.integer(DC::SamplesPerPixel).value_or(1) == 1 &&
           (slice.bitsAllocated == 8 || slice.bitsAllocated == 16) && slice.bitsStored >= 1 &&
           slice.highBit < slice.bitsAllocated && slice.highBit + 1 >= slice.bitsStored;
}

void readPlace(const Header& header, int frame, DicomSlice& slice) {
    slice.positionMm = slice.rowDirection = slice.columnDirection = std::nullopt;
    slice.spacingMm = std::nullopt;
    if (const auto p = header.reals<3>(DC::ImagePositionPatient, frame))
        slice.positionMm = glm::dvec3((*p)[0], (*p)[1], (*p)[2]);
    if (const auto o = header.reals<6>(DC::ImageOrientationPatient, frame)) {
        slice.rowDirection = glm::dvec3((*o)[0], (*o)[1], (*o)[2]);
        slice.columnDirection = glm::dvec3((*o)[3], (*o)[4], (*o)[5]);
    }
    // PixelSpacing is the distance between rows, then between columns.
    if (const auto s = header.reals<2>(DC::PixelSpacing, frame))
        slice.spacingMm = glm::dvec2((*s)[1], (*s)[0]);
    slice.slope = header.real(DC::RescaleSlope, frame);
    slice.intercept = header.real(DC::RescaleIntercept, frame);
    slice.paddingFirst = storedValueOf(header.integer(DC::PixelPaddingValue, frame), slice);
    slice.paddingLast = storedValueOf(header.integer(DC::PixelPaddingRangeLimit, frame), slice);
    if (!slice.paddingLast)
        slice.paddingLast = slice.paddingFirst;
    if (slice.paddingFirst && *slice.paddingLast < *slice.paddingFirst)
        std::swap(slice.paddingFirst, slice.paddingLast);
}

/// Bytes under a name that a parser can open, without touching a disk (they hold identifiers).
class MemoryFile {
  public:
    explicit MemoryFile(const std::vector<std::byte>& bytes)
        : descriptor_(::memfd_create("tessera", MFD_CLOEXEC)) {
        if (descriptor_ < 0 ||
            ::write(descriptor_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
            if (descriptor_ >= 0)
                ::close(descriptor_);
            throw Error("no memory file for a deflated DICOM file");
        }
    }
    ~MemoryFile() { ::close(descriptor_); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

  private:
    int descriptor_;
};

/// Scans files into series.
class Scanner {
  public:
    void add(const std::filesystem::path& file) {
        if (!looksLikeDicom(file)) {
            ++scan_.otherFiles;
            return;
        }
        vtkNew<vtkDICOMMetaData> data;
        vtkNew<vtkDICOMParser> parser;
        parse(*parser, *data, file.string());
        const std::string syntax = Header(data).text(DC::TransferSyntaxUID);
        std::optional<MemoryFile> inflated;
        if (syntax == kDeflatedSyntax) {
            try {
                inflated.emplace(inflateDicom(file));
                data->Clear();
                parse(*parser, *data, inflated->path());
            } catch (const InputError&) {
                return damaged(file, "a deflated DICOM file", "one that does not inflate");
            }
        }
        const Header header(data);
        const std::string storageClass =
            header.text(syntax == kDeflatedSyntax ? DC::SOPClassUID : DC::MediaStorageSOPClassUID);
        if (parser->GetPixelDataFound())
            return addImage(file, inflated ? std::filesystem::path(inflated->path()) : file, header, syntax,
                            *parser);
        if (contains(kSliceClasses, storageClass) || (storageClass.empty() && parser->GetErrorCode() != 0))
            damaged(file, "a whole DICOM image", "a header that breaks off (is it truncated?)");
        else
            ++scan_.otherFiles;
    }

    DicomScan take() {
        // A series in which nothing has a position (a radiograph, a screen shot) is no volume. One in which
        // something has is kept whole, so that a slice without a position is noticed.
        std::erase_if(scan_.series, [this](const DicomSeries& series) {
            const bool placed =
                std::any_of(series.slices.begin(), series.slices.end(),
                            [](const DicomSlice& slice) { return slice.positionMm.has_value(); });
            if (!placed)
                scan_.imagesWithoutPlace += static_cast<int>(series.slices.size());
            return !placed;
        });
        return std::move(scan_);
    }

  private:
    static void parse(vtkDICOMParser& parser, vtkDICOMMetaData& data, const std::string& file) {
        parser.SetMetaData(&data);
        parser.SetFileName(file.c_str());
        parser.Update();
    }

    void damaged(const std::filesystem::path& file, std::string expected, std::string found) {
        scan_.damaged.push_back({file, std::move(expected), std::move(found)});
    }

    /// @param parsed  what the parser has read: the file, or what it inflates to
    void addImage(const std::filesystem::path& file, const std::filesystem::path& parsed,
                  const Header& header, const std::string& syntax, vtkDICOMParser& parser) {
        DicomSlice slice;
        slice.file = file;
        const int frames = std::max(1, header.integer(DC::NumberOfFrames).value_or(1));
        if (!readPixelFormat(header, slice)) {
            ++scan_.imagesWithoutPlace;
            return;
        }
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
        // No codec here gains more than a thousandfold; a larger claim is not worth allocating for.
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

        const DicomLayout layout{syntax == kExplicitBig, syntax == kImplicitLittle, offset,
                                 parser.GetPixelDataVL(), compressed != nullptr};
        slice.irregularity = syntax.empty() ? "" : irregularityOf(parsed, layout);
        if (slice.irregularity.empty())
            slice.irregularity = missingTag(header);

        DicomSeries& series = seriesOf(header);
        for (int frame = 0; frame < frames; ++frame) {
            readPlace(header, frame, slice);
            slice.pixelOffsetBytes = offset + static_cast<std::uint64_t>(frame) * frameBytes;
            if (compressed)
                slice.fragments = std::move(fragments[static_cast<std::size_t>(frame)]);
            series.slices.push_back(slice);
        }
    }

    /// The fragments of each frame; what the first stream's own header says of its loss goes to slice.
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
        const bool clean = uid.size() <= 64 && uid.find_first_not_of("0123456789.") == std::string::npos;
        return clean ? uid : "(not a UID)";
    }

    DicomSeries& seriesOf(const Header& header) {
        const std::string uid = header.text(DC::SeriesInstanceUID);
        const auto [at, isNew] = indexOfUid_.try_emplace(uid, scan_.series.size());
        if (isNew) {
            DicomSeries series;
            series.acquisition.modality = codeWord(header.text(DC::Modality));
            series.acquisition.kernel = codeWord(header.text(DC::ConvolutionKernel));
            series.acquisition.tubeVoltageKv = header.real(DC::KVP).value_or(0);
            series.acquisition.sliceThicknessMm = header.real(DC::SliceThickness).value_or(0);
            series.betweenSlicesMm = std::abs(header.real(DC::SpacingBetweenSlices).value_or(0));
            const std::string type = header.text(DC::RescaleType);
            series.isHounsfield = series.acquisition.modality == "CT" && header.real(DC::RescaleIntercept) &&
                                  (type.empty() || type == "HU");
            scan_.series.push_back(std::move(series));
        }
        return scan_.series[at->second];
    }

    DicomScan scan_;
    std::map<std::string, std::size_t> indexOfUid_; // a UID identifies a study: it stays in here
};

} // namespace

bool looksLikeDicom(const std::filesystem::path& file) {
    try {
        std::array<std::byte, 132> head{};
        return InputFile(file).readSome(0, head) == head.size() &&
               std::memcmp(head.data() + 128, "DICM", 4) == 0;
    } catch (const Error&) {
        return false;
    }
}

DicomScan scanDicom(const std::filesystem::path& fileOrFolder) {
    std::error_code error;
    if (!std::filesystem::exists(fileOrFolder, error))
        throw badFile(fileOrFolder.string(), "a file or a folder", "nothing");
    std::vector<std::filesystem::path> files;
    if (std::filesystem::is_directory(fileOrFolder, error)) {
        files = sourceFilesBelow(fileOrFolder);
    } else {
        files.push_back(fileOrFolder);
    }
    const QuietVtk quiet;
    Scanner scanner;
    for (const auto& file : files)
        scanner.add(file);
    return scanner.take();
}

} // namespace tessera
