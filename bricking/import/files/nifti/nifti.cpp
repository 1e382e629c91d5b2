// bricking/import/files/nifti/nifti.cpp: openNifti of nifti.h. Uncompressed files are read by position, gzip
// files in one forward pass.
#include "bricking/import/files/nifti/nifti.h"

#include "bricking/import/files/file_format.h"
#include "bricking/import/files/file_reading.h"
#include "bricking/import/source/phase_choice.h"
#include "bricking/import/source/slice_converter.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace tessera {

void checkNiftiSurplus(const std::string& path, const NiftiHeader& header, std::uint64_t surplusBytes) {
    const std::uint64_t row =
        static_cast<std::uint64_t>(header.info.extentVoxels.x) * bytesPerFileValue(header.type);
    if (surplusBytes >= row)
        throw badFile(path, "voxels up to the end of the file, as its dimensions say",
                      std::to_string(surplusBytes) + " bytes more, " + std::to_string(surplusBytes / row) +
                          " rows");
}

namespace {

// Deflate cannot shrink by more than 1032 to 1 (zlib's technical note), so a small file cannot hold a huge
// volume: such a header is wrong.
constexpr double kLargestGzipRatio = 1032;

class GzipNiftiVoxels final : public VoxelStream {
  public:
    GzipNiftiVoxels(std::filesystem::path path, const NiftiHeader& header, int time)
        : path_(std::move(path)), header_(header), time_(time), stream_(niftiVoxels(path_, header_, time)) {}
    void read(std::span<std::byte> out) override { stream_.read(out); }
    void finish() override {
        const std::uint64_t later = static_cast<std::uint64_t>(header_.times - 1 - time_) *
                                    voxelBytesInFile(header_.info, header_.type);
        const std::uint64_t left = stream_.finish();
        if (left < later)
            throw badFile(path_.string(), "as many volumes as its header says", "fewer");
        checkNiftiSurplus(path_.string(), header_, left - later);
    }

  private:
    std::filesystem::path path_;
    NiftiHeader header_;
    int time_;
    GzipStream stream_;
};

std::string describeNifti(const NiftiHeader& header, bool compressed) {
    std::string text = "NIfTI-" + std::to_string(header.version) + (compressed ? " (gzip), " : ", ") +
                       name(header.type) + ", orientation from " + header.orientation;
    if (losesPrecision(header.type))
        text += ", converted to float32";
    return text;
}

void checkLength(const std::string& path, const NiftiHeader& header, double available) {
    const double needed = static_cast<double>(header.dataOffsetBytes) +
                          header.times * static_cast<double>(voxelBytesInFile(header.info, header.type));
    if (needed > available) {
        const glm::ivec3 n = header.info.extentVoxels;
        throw badFile(path,
                      std::to_string(static_cast<std::uint64_t>(needed)) + " bytes for " +
                          std::to_string(n.x) + " x " + std::to_string(n.y) + " x " + std::to_string(n.z) +
                          (header.times > 1 ? " x " + std::to_string(header.times) + " (dim[4])" : "") +
                          " voxels of " + name(header.type),
                      "at most " + std::to_string(static_cast<std::uint64_t>(available)) + " bytes");
    }
}

} // namespace

NiftiFile openNiftiFile(const std::filesystem::path& path) {
    InputFile file(path);
    std::array<std::byte, kNiftiHeaderBytes> head{};
    const std::size_t got = file.readSome(0, head);
    const bool isGzip = got >= 2 && head[0] == std::byte{0x1f} && head[1] == std::byte{0x8b};
    if (!isGzip) {
        const NiftiHeader header = parseNiftiHeader(std::span(head).first(got), path.string());
        checkLength(path.string(), header, static_cast<double>(file.sizeBytes()));
        checkNiftiSurplus(path.string(), header,
                          file.sizeBytes() - header.dataOffsetBytes -
                              static_cast<std::uint64_t>(header.times) *
                                  voxelBytesInFile(header.info, header.type));
        return {std::move(file), header, false};
    }
    const double largest = static_cast<double>(file.sizeBytes()) * kLargestGzipRatio;
    GzipStream stream(InputFile{path});
    stream.read(std::span(head).first(348));
    std::size_t have = 348;
    // A NIfTI-2 header is longer; only then are more bytes sure to exist.
    const auto first = std::to_integer<int>(head[0]), last = std::to_integer<int>(head[3]);
    if ((first == 540 % 256 && last == 0) || (first == 0 && last == 540 % 256)) {
        stream.read(std::span(head).subspan(have));
        have = kNiftiHeaderBytes;
    }
    const NiftiHeader header = parseNiftiHeader(std::span(head).first(have), path.string());
    checkLength(path.string(), header, largest);
    return {std::move(file), header, true};
}

GzipStream niftiVoxels(const std::filesystem::path& path, const NiftiHeader& header, int time) {
    const std::uint64_t first = header.dataOffsetBytes +
                                static_cast<std::uint64_t>(time) * voxelBytesInFile(header.info, header.type);
    GzipStream stream{InputFile(path)};
    std::vector<std::byte> skipped(64 * 1024);
    for (std::uint64_t at = 0; at < first;) {
        const auto step = std::min<std::uint64_t>(skipped.size(), first - at);
        stream.read(std::span(skipped).first(step));
        at += step;
    }
    return stream;
}

namespace {
std::vector<std::string> phasesOfNifti(const NiftiHeader& header) {
    return header.times > 1 ? phaseLabels(static_cast<std::size_t>(header.times), header.stepSeconds)
                            : std::vector<std::string>{};
}
} // namespace

std::unique_ptr<SlabSource> openNifti(const std::filesystem::path& path, int phase) {
    NiftiFile nifti = openNiftiFile(path);
    const NiftiHeader& header = nifti.header;
    const auto time = static_cast<int>(chosenPhase(phasesOfNifti(header), phase, path.string()));
    if (nifti.isGzip)
        return makeForwardFileSource(
            [path, header, time] { return std::make_unique<GzipNiftiVoxels>(path, header, time); },
            header.info, header.type, header.bigEndian, describeNifti(header, true));
    return makePlainFileSource(std::move(nifti.file), header.info,
                               {header.type, header.bigEndian,
                                header.dataOffsetBytes + static_cast<std::uint64_t>(time) *
                                                             voxelBytesInFile(header.info, header.type)},
                               describeNifti(header, false));
}

FileFormat niftiFormat() {
    return {.inFolders = "NIfTI files",
            .named = ".nii, .nii.gz",
            .open = [](const std::filesystem::path& path,
                       const SourceOptions& options) { return openNifti(path, options.phase); },
            .phases =
                [](const std::filesystem::path& path) { return phasesOfNifti(openNiftiFile(path).header); }};
}

} // namespace tessera
