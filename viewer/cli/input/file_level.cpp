// viewer/cli/input/file_level.cpp: see file_level.h.
#include "viewer/cli/input/file_level.h"

#include "core/base/address.h"
#include "core/base/budget.h" // formatBytes
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "viewer/cli/input/import_cache.h"
#include "viewer/cli/input/remote_input.h"
#if TESSERA_WITH_IMPORT
#include "bricking/import/catalogue.h"
#include "bricking/import/source/file_levels.h"
#endif

#include <cstdint>
#include <system_error>
#include <vector>

namespace tessera {

#if TESSERA_WITH_IMPORT
namespace {

/// Of the volume that options choose: finest first, at least one.
std::vector<VolumeInfo> levelsFor(const std::filesystem::path& path, const InputOptions& options,
                                  std::uint64_t enough) {
    SourceOptions source;
    source.series = options.series;
    source.phase = options.phase;
    source.largest = options.largest;
    source.allowMissing = options.allowMissing;
    source.spacingMm = options.spacingMm;
    const Catalogue catalogue = lookThrough(path, source);
    const CatalogueRow& row = chooseRow(catalogue, source);
    if (!row.info) // opening it says why
        return {};
    std::vector<VolumeInfo> levels;
    if (decodedBytes(*row.info) > enough)
        levels = fileLevelsOf(catalogue, row, source);
    return levels.empty() ? std::vector{*row.info} : levels;
}

} // namespace

InputOptions withFileLevel(const std::filesystem::path& given, const InputOptions& options,
                           const CommonOptions& common, UnsaidLevel unsaid) {
    const bool isAuto = options.fileLevel == SourceChoice::kAutoLevel;
    if (isAuto && options.fileBox)
        throw badFile("--file-level", "a number beside --file-box, which counts that level's voxels", "auto");
    const std::filesystem::path path = reached(given);
    if (isAuto && options.spacingMm)
        throw badFile("--file-level", "a number beside --spacing, which is of that level's voxels", "auto");
    if (!isAuto && options.spacingMm) // of the finest level
        return options;
    if (!isAuto &&
        (options.fileLevel || options.fileBox || unsaid == UnsaidLevel::finest || !mayHaveLevels(path)))
        return options;
    InputOptions chosen = options;
    chosen.fileLevel.reset();
    const std::uint64_t most = cacheLimitBytes();
    const std::vector<VolumeInfo> levels = levelsFor(path, options, most);
    const int level = levels.empty() ? 0 : levelWithin(levels, most);
    if (level == 0)
        return chosen;
    chosen.fileLevel = level;
    common.note(path.string() + " has " + formatExtent(levels.front().extentVoxels) +
                " voxels at its finest level, " + formatBytes(decodedBytes(levels.front())) +
                ", and the cache of imports has room for " + formatBytes(most) + ": level " +
                std::to_string(level) + " is taken, " +
                formatExtent(levels[static_cast<std::size_t>(level)].extentVoxels) +
                " voxels; --file-level chooses another, --file-box a part");
    return chosen;
}

std::optional<int> levelToBeginWith(const std::filesystem::path& given, const InputOptions& options,
                                    std::uint64_t bytes) {
    const std::filesystem::path path = reached(given);
    std::error_code ignored;
    if (options.spacingMm || (options.fileLevel && options.fileLevel != SourceChoice::kAutoLevel) ||
        options.fileBox || (!isAddress(path) && !std::filesystem::exists(path, ignored)) ||
        !mayHaveLevels(path))
        return std::nullopt;
    try {
        CommonOptions quiet;
        quiet.quiet = true;
        const InputOptions meant = withFileLevel(path, options, quiet, UnsaidLevel::fits);
        const std::vector<VolumeInfo> levels = levelsFor(path, options, bytes);
        const int level = levels.empty() ? 0 : levelWithin(levels, bytes);
        if (level <= meant.fileLevel.value_or(0) ||
            decodedBytes(levels[static_cast<std::size_t>(level)]) > bytes || isCached(path, meant.key()))
            return std::nullopt;
        return level;
    } catch (const InputError&) { // such as a level that is not there: opening the finest says what matters
        return std::nullopt;
    }
}
#else
InputOptions withFileLevel(const std::filesystem::path&, const InputOptions& options, const CommonOptions&,
                           UnsaidLevel) {
    return options;
}

std::optional<int> levelToBeginWith(const std::filesystem::path&, const InputOptions&, std::uint64_t) {
    return std::nullopt;
}
#endif

std::string sayFilePart(const FilePart& part) {
    std::string text =
        "level " + std::to_string(part.level) + " of its file, " + formatExtent(part.levelVoxels) + " voxels";
    if (part.level > 0)
        text += " (the finest has " + formatExtent(part.finestVoxels) + ")";
    const auto& [low, high] = part.box;
    if (low == glm::ivec3(0) && high == part.levelVoxels)
        return text;
    text += ", box ";
    for (int axis = 0; axis < 3; ++axis)
        text += (axis ? "," : "") + std::to_string(low[axis]) + "," + std::to_string(high[axis]);
    return text;
}

void addFilePartOptions(Command& command, SourceChoice& choice) {
    command.option(
        "--file-level",
        [&choice](const std::string& text) { choice.fileLevel = parseFileLevel(text, "--file-level"); },
        "source files that have the volume at several resolutions: the level to take, 0 the finest; auto: "
        "the "
        "finest that the cache of imports has room for (default: 0, or as auto where it has no room for 0)");
    command.option(
        "--file-box",
        [&choice](const std::string& text) { choice.fileBox = parseFileBox(text, "--file-box"); },
        "source files: only a box, in voxels of that level along the volume's axes: X0,X1,Y0,Y1,Z0,Z1, whose "
        "second corner is the first voxel beyond");
}

} // namespace tessera
