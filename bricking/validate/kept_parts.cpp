// bricking/validate/kept_parts.cpp: see kept_parts.h.
#include "bricking/validate/kept_parts.h"

#include "bricking/analysis/body/kept_table.h"
#include "bricking/labels/label_files.h"
#include "bricking/statistics/check_statistics.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/store_files.h"
#include "bricking/validate/written_place.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/volume.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <glm/common.hpp>
#include <set>
#include <span>
#include <system_error>
#include <vector>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr const char* kTablePart = "stats/table";
constexpr const char* kHistogramPart = "stats/histograms";
constexpr const char* kLabelPart = "sets";

/// Files below a folder or file, by their path from it.
std::set<fs::path> filesOf(const fs::path& root) {
    std::set<fs::path> files;
    std::error_code error;
    if (!fs::is_directory(fs::symlink_status(root, error)))
        return {fs::path()};
    for (fs::recursive_directory_iterator entry(root, error), end; !error && entry != end;
         entry.increment(error))
        if (!fs::is_directory(entry->symlink_status(error)))
            files.insert(entry->path().lexically_relative(root));
    return files;
}

bool haveSameBytes(const fs::path& a, const fs::path& b) {
    std::error_code error;
    if (!fs::is_regular_file(fs::symlink_status(a, error)) ||
        !fs::is_regular_file(fs::symlink_status(b, error)))
        return false;
    std::ifstream first(a, std::ios::binary), second(b, std::ios::binary);
    std::array<char, 65536> one{}, other{};
    while (first && second) {
        first.read(one.data(), one.size());
        second.read(other.data(), other.size());
        if (first.gcount() != second.gcount() ||
            std::memcmp(one.data(), other.data(), static_cast<std::size_t>(first.gcount())) != 0)
            return false;
    }
    return first.eof() && second.eof();
}

/// The numbers of a chunk of labels in a slab of slices, whose first slice is the chunk's.
/// @param first  of the chunk in the slab
void takeNumbers(std::span<const std::byte> chunk, ValueType type, const glm::ivec3& first,
                 const glm::ivec3& extent, std::span<std::uint16_t> slab) {
    const glm::ivec3 size = glm::min(extent - first, glm::ivec3(kChunkExtent));
    for (int z = 0; z < kChunkExtent; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const std::size_t from =
                    linearIndex({x, y, z}, glm::ivec3(kChunkExtent)) * bytesPerValue(type);
                slab[linearIndex(first + glm::ivec3(x, y, z), {extent.x, extent.y, kChunkExtent})] =
                    static_cast<std::uint16_t>(storedValue(type, chunk.data() + from));
            }
}

} // namespace

/// White space of documents, which no checksum covers.
void KeptParts::checkTexts() {
    constexpr std::uint64_t kMostBytes = 1 << 20;
    const StoreFolder folder = openFolder(store_.path());
    for (const fs::path& file : filesOf(store_.path() / "stats")) {
        if (file.filename() != "zarr.json" || file.string().front() == '.') // those of dead processes
            continue;
        const std::string relative = "stats/" + file.string(), where = (store_.path() / relative).string();
        const std::string part = "stats/" + file.begin()->string();
        if (faults_.has(part))
            continue;
        try {
            const auto text = readText(folder, relative, store_.path(), kMostBytes);
            if (text && *text != storedText(parseJson(*text, where)))
                throw badFile(where, "the text that its content gives",
                              "other white space, or another order");
        } catch (const BadFile& problem) {
            faults_.add(part, problem.what());
        }
    }
}

void KeptParts::check() {
    const StatisticsFault found = [&](const std::string& part, const BadFile& problem) {
        faults_.add(part, problem.what());
    };
    version_ = checkStatistics(store_, ram_, found);
    if (version_ != 0 && !faults_.has(statisticsParts().back()) && version_ != newestStatistics())
        notes_.push_back("statistics are of version " + std::to_string(version_) +
                         ", which is read; this program writes " + std::to_string(newestStatistics()));
    checkLocalHistograms(store_, ram_, found);
    try {
        keptTableOf(store_, ram_);
    } catch (const BadFile& problem) {
        faults_.add(kTablePart, problem.what());
    }
    checkTexts();
}

void KeptParts::checkLabels() {
    try {
        readLabelFiles(store_, ram_);
    } catch (const BadFile& problem) {
        faults_.add(kLabelPart, problem.what());
    }
}

bool KeptParts::hasStatisticsFaults() const {
    const auto& parts = statisticsParts();
    return std::any_of(parts.begin(), parts.end(),
                       [&](const std::string& part) { return faults_.has(part); });
}

/// Makes statistics, or the mask of the table, in FOLDER/stats, as an import does.
void KeptParts::make(const fs::path& folder, bool withStatistics, bool withTable, const ShareDone& progress) {
    if (withStatistics)
        buildStatistics(store_, folder, ram_, threads_, progress);
    if (withTable)
        keepTable(findTable(store_, ram_, threads_), store_, folder);
}

bool KeptParts::isSame(const fs::path& made, const std::string& part) const {
    const std::set<fs::path> files = filesOf(made / part);
    if (files != filesOf(store_.path() / part))
        return false;
    return std::all_of(files.begin(), files.end(), [&](const fs::path& file) {
        return file.empty() ? haveSameBytes(made / part, store_.path() / part)
                            : haveSameBytes(made / part / file, store_.path() / part / file);
    });
}

void KeptParts::compare(const ShareDone& progress) {
    if (version_ != 0 && version_ != newestStatistics())
        return; // they hold less, on purpose
    std::error_code ignored;
    const bool hasTable = fs::exists(store_.path() / kTablePart, ignored);
    const TemporaryFolder made(fs::temp_directory_path() / "tessera-statistics.zarr");
    make(made.path(), true, hasTable, progress);
    std::vector<std::string> parts = statisticsParts();
    if (hasTable)
        parts.emplace_back(kTablePart);
    for (const std::string& part : parts)
        if (!faults_.has(part) && !isSame(made.path(), part))
            faults_.add(
                part,
                badFile((store_.path() / part).string(), "what the voxels give", "something else").what());
    if (hasStatisticsFaults() || faults_.has(kHistogramPart))
        return;
    const StatisticsFault found = [&](const std::string& part, const BadFile& problem) {
        faults_.add(part, problem.what());
    };
    if (const std::string why = compareLocalHistograms(store_, ram_, threads_, found); !why.empty())
        notes_.push_back(why);
}

void KeptParts::compareLabels() {
    if (faults_.has(kLabelPart))
        return;
    const glm::ivec3 extent = store_.info().extentVoxels;
    const std::size_t slice = cellCount({extent.x, extent.y, 1});
    try {
        const LabelTable table = readLabelTable(store_, ram_);
        const Charge charge = ram_.charge(kChunkExtent * slice * sizeof(std::uint16_t) + store_.chunkBytes() +
                                              LabelFilesWriter::bytesNeeded(extent, threads_),
                                          "comparing the cells of labels");
        const TemporaryFolder made(fs::temp_directory_path() / "tessera-labels.zarr");
        LabelFilesWriter writer(made.path(), extent, threads_);
        std::vector<std::uint16_t> slab(kChunkExtent * slice);
        std::vector<std::byte> chunk(store_.chunkBytes());
        const glm::ivec3 chunks = chunkGrid(extent, 0);
        for (int k = 0; k < chunks.z; ++k) {
            for (int j = 0; j < chunks.y; ++j)
                for (int i = 0; i < chunks.x; ++i) {
                    checkInterrupted();
                    store_.readChunk({0, i, j, k}, chunk);
                    takeNumbers(chunk, store_.info().type, glm::ivec3(i, j, 0) * kChunkExtent, extent, slab);
                }
            const int slices = std::min(kChunkExtent, extent.z - k * kChunkExtent);
            writer.add(std::span(slab).first(static_cast<std::size_t>(slices) * slice), slices);
        }
        writer.finish(table, store_);
        for (const char* array : {"counts", "set", "voxels"})
            if (const std::string part = std::string(kLabelPart) + "/" + array; !isSame(made.path(), part))
                return faults_.add(kLabelPart, badFile((store_.path() / part).string(),
                                                       "what the voxels give", "something else")
                                                   .what());
    } catch (const InputError& problem) { // of the budget, or of a number that no set has
        notes_.push_back(std::string("the cells of labels were not compared: ") + problem.what());
    }
}

void KeptParts::publish(const fs::path& made, const std::string& part) {
    fs::create_directories((store_.path() / part).parent_path());
    publishFolder(made / part, store_.path() / part, true);
}

void KeptParts::repair(bool areLevelsWhole, const ShareDone& progress) {
    const auto leaveAll = [&](const std::string& why) {
        for (const std::string& part : statisticsParts())
            if (faults_.has(part))
                faults_.leave(part, why);
        if (faults_.has(kTablePart))
            faults_.leave(kTablePart, why);
    };
    const auto mending = [&](const auto& body) {
        try {
            body();
        } catch (const Error& problem) {
            leaveAll(problem.what());
        } catch (const fs::filesystem_error& problem) {
            leaveAll(problem.code().message());
        }
    };
    if (faults_.has(kHistogramPart))
        mending([&] {
            if (const std::string why = whyNotWritten(store_.path(), kHistogramPart); !why.empty())
                return faults_.leave(kHistogramPart, why);
            fs::remove_all(store_.path() / kHistogramPart); // made again when they are asked for
            faults_.mend(kHistogramPart);
        });
    const bool withStatistics = hasStatisticsFaults(), withTable = faults_.has(kTablePart);
    if (!withStatistics && !withTable)
        return;
    if (!areLevelsWhole)
        return leaveAll("the voxels that it follows from are damaged");
    mending([&] {
        const TemporaryFolder made(store_.path() / "stats");
        make(made.path(), withStatistics, withTable, progress);
        std::vector<std::string> parts;
        if (withStatistics)
            parts = statisticsParts();
        if (withTable)
            parts.emplace_back(kTablePart);
        for (const std::string& part : parts) {
            const bool isFaulty = faults_.has(part);
            if (const std::string why = whyNotWritten(store_.path(), part); !why.empty()) {
                if (isFaulty)
                    faults_.leave(part, why);
                continue;
            }
            if (!isSame(made.path(), part))
                publish(made.path(), part);
            if (isFaulty)
                faults_.mend(part);
        }
    });
}

} // namespace tessera
