// bricking/import/dicom/could_belong.cpp: see could_belong.h.
#include "bricking/import/dicom/could_belong.h"

#include "bricking/import/source/source_files.h"
#include "core/base/error.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <optional>
#include <set>

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostDigits = 9; // longer ones are parts of UIDs, not counters
constexpr std::size_t kMostNames = 3;
constexpr std::size_t kFewSlices = 2; // largest number of slices that a damaged UID splits off a series
constexpr double kAlike = 1e-3;       // of directions and spacings, as in dicom_geometry.cpp
constexpr double kOffPlace = 0.02;    // of a gap

/// A name split at one of its numbers: "IM-0001-", ".dcm" and 42.
struct Numbered {
    std::string around;
    unsigned long number = 0;
};
std::vector<Numbered> numberings(const std::string& name) {
    std::vector<Numbered> found;
    for (std::size_t begin = 0; begin < name.size();) {
        if (!std::isdigit(static_cast<unsigned char>(name[begin]))) {
            ++begin;
            continue;
        }
        std::size_t end = begin;
        while (end < name.size() && std::isdigit(static_cast<unsigned char>(name[end])))
            ++end;
        if (end - begin <= kMostDigits)
            found.push_back({name.substr(0, begin) + "#" + name.substr(end),
                             std::stoul(name.substr(begin, end - begin))});
        begin = end;
    }
    return found;
}

/// The files of all series by folder, for the lookup of neighbours.
class Neighbours {
  public:
    /// Of all series, or of one.
    explicit Neighbours(const DicomScan& scan, std::optional<std::size_t> only = {}) {
        for (std::size_t index = only.value_or(0); index < (only ? *only + 1 : scan.series.size()); ++index)
            for (const DicomSlice& slice : scan.series[index].slices)
                add(slice.file, index);
    }

    /// The series of the files of the same name but for a number, next below and above it; empty: none is.
    std::set<std::size_t> beside(const fs::path& file) const {
        std::set<std::size_t> series;
        for (const Numbered& numbered : numberings(file.filename().string())) {
            const auto names = byName_.find((file.parent_path() / numbered.around).string());
            if (names == byName_.end())
                continue;
            const auto above = names->second.lower_bound(numbered.number);
            if (above != names->second.end())
                series.insert(above->second.begin(), above->second.end());
            if (above != names->second.begin())
                series.insert(std::prev(above)->second.begin(), std::prev(above)->second.end());
        }
        return series;
    }
    bool folderHolds(const fs::path& folder, std::size_t series) const {
        const auto at = byFolder_.find(folder.string());
        return at != byFolder_.end() && at->second.contains(series);
    }
    /// True if a file of the series in that folder has the ending; for names without one, about the length.
    bool endingHolds(const fs::path& file, std::size_t series) const {
        const auto at = byEnding_.find((file.parent_path() / endingOf(file)).string());
        return at != byEnding_.end() && at->second.contains(series);
    }
    /// True if the folder holds no slice, but the folder beside it does, under the same name: one folder per
    /// slice.
    bool sameNameBesideHolds(const fs::path& file, std::size_t series) const {
        const fs::path folder = file.parent_path();
        const auto at = bySameName_.find((folder.parent_path() / file.filename()).string());
        return byFolder_.find(folder.string()) == byFolder_.end() && at != bySameName_.end() &&
               at->second.contains(series);
    }
    /// True if three folders or more beside this one hold a slice of the series each, and none holds several
    /// slices.
    bool foldersBesideHoldASliceEach(const fs::path& folder, std::size_t series) const {
        std::size_t holding = 0;
        for (const auto& [name, slices] : slicesOfFolder_) {
            const fs::path beside(name);
            if (beside == folder || beside.parent_path() != folder.parent_path())
                continue;
            if (slices > 1)
                return false;
            holding += folderHolds(beside, series);
        }
        return holding > kFewSlices;
    }
    /// True if the folder, or one inside it, holds slices of the series.
    bool folderOrOneBelowHolds(const fs::path& folder, std::size_t series) const {
        return folderHolds(folder, series) ||
               std::any_of(byFolder_.begin(), byFolder_.end(), [&](const auto& entry) {
                   return fs::path(entry.first).parent_path() == folder && entry.second.contains(series);
               });
    }

  private:
    void add(const fs::path& file, std::size_t series) {
        const fs::path folder = file.parent_path();
        byFolder_[folder.string()].insert(series);
        ++slicesOfFolder_[folder.string()];
        byEnding_[(folder / endingOf(file)).string()].insert(series);
        bySameName_[(folder.parent_path() / file.filename()).string()].insert(series);
        for (const Numbered& numbered : numberings(file.filename().string()))
            byName_[(folder / numbered.around).string()][numbered.number].insert(series);
    }

    std::map<std::string, std::map<unsigned long, std::set<std::size_t>>> byName_;
    /// ".dcm"; for a name without a short ending of letters, a key for names of about its length.
    static std::string endingOf(const fs::path& file) {
        constexpr std::size_t kLongest = 5, kAlikeLengths = 4;
        const std::string ending = file.extension().string();
        const bool isEnding =
            ending.size() > 1 && ending.size() <= kLongest &&
            std::any_of(ending.begin(), ending.end(), [](unsigned char c) { return std::isalpha(c); });
        return isEnding ? ending : "#" + std::to_string(file.filename().string().size() / kAlikeLengths);
    }

    std::map<std::string, std::set<std::size_t>> byFolder_, byEnding_, bySameName_;
    std::map<std::string, std::size_t> slicesOfFolder_;
};

/// True if a slice continues the stack of a series. It has the same size, orientation and spacing, and is a
/// whole number of gaps from the first slice, at most one beyond the ends.
bool continues(const DicomSlice& slice, const DicomSeries& series) {
    const DicomSlice& first = series.slices.front();
    if (!slice.positionMm || !slice.rowDirection || !slice.spacingMm || !first.rowDirection ||
        !first.spacingMm || slice.columns != first.columns || slice.rows != first.rows ||
        glm::length(*slice.rowDirection - *first.rowDirection) > kAlike ||
        glm::length(*slice.columnDirection - *first.columnDirection) > kAlike ||
        glm::length(*slice.spacingMm - *first.spacingMm) > kAlike)
        return false;
    const glm::dvec3 normal = glm::cross(*first.rowDirection, *first.columnDirection);
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const DicomSlice& each : series.slices)
        if (each.positionMm) {
            least = std::min(least, glm::dot(*each.positionMm, normal));
            most = std::max(most, glm::dot(*each.positionMm, normal));
        }
    const double gap = (most - least) / static_cast<double>(series.slices.size() - 1);
    const double steps = (glm::dot(*slice.positionMm, normal) - least) / gap;
    return std::abs(steps - std::round(steps)) < kOffPlace && steps > -1.5 &&
           steps < static_cast<double>(series.slices.size()) + 0.5;
}

/// Slices that continue a series under another SeriesInstanceUID.
std::vector<PassedFile> straysOf(const DicomScan& scan, std::size_t series) {
    std::vector<PassedFile> found;
    const DicomSeries& own = scan.series[series];
    if (own.isScout || own.slices.size() <= kFewSlices)
        return found;
    std::optional<Neighbours> neighbours;
    for (std::size_t index = 0; index < scan.series.size(); ++index) {
        const DicomSeries& other = scan.series[index];
        if (index == series || other.isScout || other.slices.size() > kFewSlices)
            continue;
        for (const DicomSlice& slice : other.slices) {
            if (!continues(slice, own))
                continue;
            if (!neighbours)
                neighbours.emplace(scan, series);
            if (!neighbours->beside(slice.file).empty())
                found.push_back({slice.file, PassedReason::damaged,
                                 "the SeriesInstanceUID (0020,000e) of the series whose stack it continues",
                                 "another one"});
        }
    }
    return found;
}

bool belongs(const PassedFile& file, std::size_t series, const Neighbours& neighbours) {
    switch (file.reason) {
    case PassedReason::empty:
    case PassedReason::zeroFilled:
    case PassedReason::notReadable:
    case PassedReason::damaged:
    case PassedReason::notDicom:
        break;
    case PassedReason::emptyFolder:
        return neighbours.beside(file.path).contains(series) ||
               neighbours.foldersBesideHoldASliceEach(file.path, series);
    case PassedReason::folderNotReadable:
        return neighbours.folderOrOneBelowHolds(file.path.parent_path(), series);
    default:
        return false;
    }
    if (file.reason == PassedReason::damaged && (file.series || file.seriesIsAnother))
        return file.series == series;
    const std::set<std::size_t> beside = neighbours.beside(file.path);
    if (!beside.empty())
        return beside.contains(series);
    if (neighbours.sameNameBesideHolds(file.path, series))
        return true;
    return file.reason == PassedReason::notDicom ? neighbours.endingHolds(file.path, series)
                                                 : neighbours.folderHolds(file.path.parent_path(), series);
}

} // namespace

std::vector<PassedFile> couldBelong(const DicomScan& scan, std::size_t series) {
    std::vector<PassedFile> found = straysOf(scan, series);
    if (scan.passed.empty())
        return found;
    const Neighbours neighbours(scan);
    for (const PassedFile& file : scan.passed)
        if (belongs(file, series, neighbours))
            found.push_back(file);
    return found;
}

void requireComplete(const DicomScan& scan, std::size_t series) {
    const std::vector<PassedFile> missing = couldBelong(scan, series);
    if (missing.empty())
        return;
    const PassedFile& first = missing.front();
    std::string others;
    for (std::size_t i = 1; i < std::min(missing.size(), 1 + kMostNames); ++i)
        others += (i == 1 ? "; likewise " : ", ") + printableName(missing[i].path.filename()) + ": " +
                  foundIn(missing[i]);
    if (missing.size() > 1 + kMostNames)
        others += " and " + std::to_string(missing.size() - 1 - kMostNames) + " more";
    const std::string number = std::to_string(series + 1);
    const std::string expected = first.reason == PassedReason::damaged ? first.expected
                                 : first.reason == PassedReason::folderNotReadable
                                     ? "a readable folder, as it could hold slices of series " + number
                                     : "a slice of series " + number + ", as the files beside it are";
    throw badFile(printableName(first.path), expected,
                  foundIn(first) + others + "; --allow-missing leaves " +
                      (missing.size() > 1 ? "them" : "it") + " out");
}

} // namespace tessera
