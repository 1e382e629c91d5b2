// bricking/import/dicom/dicom_source.cpp: see dicom.h.
#include "bricking/import/dicom/dicom_source.h"

#include "bricking/import/dicom/could_belong.h"
#include "bricking/import/dicom/dicom_geometry.h"
#include "bricking/import/dicom/dicom_phases.h"
#include "bricking/import/dicom/dicom_pixels.h"
#include "bricking/import/dicom/dicom_remarks.h"
#include "bricking/import/source/blended_slices.h"
#include "bricking/import/source/plausible.h"
#include "bricking/import/source/slab_source.h"
#include "bricking/import/source/source_files.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <map>
#include <tuple>
#include <utility>

namespace tessera {
namespace {

constexpr double kAirHu = -1024; // the least value of a 12-bit CT

bool isWhole(double value) {
    return value == std::floor(value) && std::abs(value) < 0x1p24;
}

double slopeOf(const DicomSlice& slice) {
    return slice.slope.value_or(1);
}
double interceptOf(const DicomSlice& slice) {
    return slice.intercept.value_or(0);
}

/// The type that holds every value the headers allow, if one does; int16 for HU in any case.
ValueType chooseType(const DicomSeries& series) {
    double least = 0, most = 0;
    bool whole = true;
    for (const DicomSlice& slice : series.slices) {
        whole = whole && isWhole(slopeOf(slice)) && isWhole(interceptOf(slice));
        const double range = std::ldexp(1.0, slice.bitsStored);
        const double first = slice.isSigned ? -range / 2 : 0;
        for (const double stored : {first, first + range - 1}) {
            least = std::min(least, slopeOf(slice) * stored + interceptOf(slice));
            most = std::max(most, slopeOf(slice) * stored + interceptOf(slice));
        }
    }
    if (!whole)
        return ValueType::f32;
    if (series.isHounsfield || (least >= -32768 && most <= 32767))
        return ValueType::i16;
    return least >= 0 && most <= 65535 ? ValueType::u16 : ValueType::f32;
}

void checkRescale(const DicomSeries& series, const std::string& where) {
    if (!series.disagreement.empty())
        throw badFile(where, series.disagreement + " the same in every slice", "more than one");
    const DicomSlice& first = series.slices.front();
    for (const DicomSlice& slice : series.slices) { // a slice without it would be shifted against the others
        const bool noSlope = slice.slope.has_value() != first.slope.has_value();
        if (noSlope || slice.intercept.has_value() != first.intercept.has_value())
            throw badFile(where,
                          std::string(noSlope ? "RescaleSlope (0028,1053)" : "RescaleIntercept (0028,1052)") +
                              " in every slice or in none",
                          "one with and one without: " + printableName(first.file.filename()) + " and " +
                              printableName(slice.file.filename()));
    }
    for (const DicomSlice& slice : series.slices)
        requirePlausibleRescale(slopeOf(slice), interceptOf(slice), std::ldexp(1.0, slice.bitsStored),
                                series.isHounsfield, "RescaleSlope (0028,1053)",
                                "RescaleIntercept (0028,1052)",
                                where + " (" + printableName(slice.file.filename()) + ")");
}

/// A slice with a header unlike most others is damaged; if most are like this, it is the writer's habit.
/// Returns the remark on such a habit.
std::string checkRegular(const DicomSeries& series) {
    const auto isOdd = [](const DicomSlice& slice) { return !slice.irregularity.empty(); };
    const auto odd = std::count_if(series.slices.begin(), series.slices.end(), isOdd);
    if (odd == 0)
        return "";
    const DicomSlice& first = *std::find_if(series.slices.begin(), series.slices.end(), isOdd);
    if (2 * odd <= static_cast<std::ptrdiff_t>(series.slices.size()))
        throw badFile(first.file.string(), "a header without fault, as most slices of its series have",
                      first.irregularity);
    return "irregular headers, in most slices alike (" + first.irregularity + "): read all the same";
}

/// Slices of one series have one number format. A few with another format are damaged, because a flipped bit
/// there shifts or wraps every value. If there are many, each is read by its own format, and this is
/// reported.
std::string checkFormats(const DicomSeries& series) {
    using Format = std::tuple<int, int, int, bool>;
    const auto formatOf = [](const DicomSlice& s) {
        return Format{s.bitsAllocated, s.bitsStored, s.highBit, s.isSigned};
    };
    std::map<Format, std::size_t> counts;
    for (const DicomSlice& slice : series.slices)
        ++counts[formatOf(slice)];
    if (counts.size() == 1)
        return "";
    const auto common = std::max_element(counts.begin(), counts.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
    const DicomSlice& odd =
        *std::find_if(series.slices.begin(), series.slices.end(),
                      [&](const DicomSlice& slice) { return formatOf(slice) != common->first; });
    const auto words = [](const Format& format) {
        const auto& [allocated, stored, highBit, isSigned] = format;
        return std::string(isSigned ? "signed " : "unsigned ") + std::to_string(stored) + " of " +
               std::to_string(allocated) + " bits, the highest " + std::to_string(highBit);
    };
    constexpr std::size_t kFew = 10; // of so many, one
    const std::size_t others = series.slices.size() - common->second;
    if (series.slices.size() > 2 && others <= std::max<std::size_t>(1, series.slices.size() / kFew))
        throw badFile(odd.file.string(), "pixels of " + words(common->first) + ", as the other slices have",
                      words(formatOf(odd)));
    return "slices of several number formats: each is read by its own";
}

VolumeInfo describeVolume(const DicomSeries& series, const SlicePlan& plan, const std::string& where) {
    const DicomSlice& first = series.slices[static_cast<std::size_t>(plan.order.front())];
    VolumeInfo info;
    info.extentVoxels = {first.columns, first.rows, static_cast<int>(plan.samples.size())};
    info.type = chooseType(series);
    info.unit = series.isHounsfield ? "HU" : "";
    info.patientFromVoxel = plan.patientFromVoxel;
    info.acquisition = series.acquisition;
    info.frameOfReference = series.frameOfReference;
    for (const DicomSlice& slice : series.slices) {
        info.lossy = info.lossy || slice.lossy;
        info.lossyRatio = std::max(info.lossyRatio, slice.lossyRatio);
    }
    if (series.isHounsfield) {
        info.fillStored = kAirHu;
    } else if (first.paddingFirst) {
        const double fill = slopeOf(first) * *first.paddingFirst + interceptOf(first);
        const bool fits = info.type == ValueType::f32 ||
                          (info.type == ValueType::i16 && std::abs(fill) <= 32767) ||
                          (info.type == ValueType::u16 && fill >= 0 && fill <= 65535);
        info.fillStored = fits ? static_cast<double>(static_cast<float>(fill)) : 0;
    }
    requirePlausibleGeometry(info,
                             {"PixelSpacing (0028,0030) and slice distance",
                              "ImageOrientationPatient (0020,0037) and the slices' positions",
                              "ImagePositionPatient (0020,0032)"},
                             where);
    info.validate(where);
    return info;
}

/// The factor that all slices of a PET have, or a remark that says why there is none.
void takeSuv(const DicomSeries& series, VolumeInfo& info) {
    if (series.acquisition.modality != "PT")
        return;
    const double first = series.slices.front().suvPerValue;
    const bool alike = std::all_of(series.slices.begin(), series.slices.end(), [&](const DicomSlice& slice) {
        return std::abs(slice.suvPerValue - first) <= 1e-6 * first;
    });
    if (first > 0 && alike)
        info.suvPerValue = first;
    else
        info.remarks.push_back(
            "SUV is not known: the header lacks " +
            (series.suvMissing.empty() ? "one weight, dose and time for all slices" : series.suvMissing));
}

/// All checks without pixels, and the remarks.
std::pair<SlicePlan, VolumeInfo> checkedVolume(DicomSeries& series, bool resampleZ, bool ofSeveralPhases,
                                               const std::string& where) {
    takeCommonAcquisition(series);
    checkRescale(series, where);
    SlicePlan plan = planSlices(series, resampleZ, where);
    VolumeInfo info = describeVolume(series, plan, where);
    info.remarks = remarksOn(series, plan, ofSeveralPhases);
    takeSuv(series, info);
    for (std::string line : {checkRegular(series), checkFormats(series)})
        if (!line.empty())
            info.remarks.push_back(std::move(line));
    return {std::move(plan), std::move(info)};
}

class DicomSource final : public RandomSlabSource {
  public:
    DicomSource(DicomSeries series, SlicePlan plan, VolumeInfo info, std::string description)
        : series_(std::move(series)), plan_(std::move(plan)), info_(std::move(info)),
          description_(std::move(description)) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return description_; }

    std::vector<std::string> notes() const override {
        std::vector<std::string> lines = info_.remarks;
        for (const std::string* line : {&findings_.beyond, &findings_.disagreement, &findings_.mended})
            if (!line->empty())
                lines.push_back(*line);
        return lines;
    }

    std::size_t roomBytes() const override {
        return decodingBytes() +
               (plan_.resampled ? 2 * sliceBytesOf(info_) : 0); // neighbours that are blended
    }
    void setThreads(int threads) override { threads_ = threads > 0 ? threads : defaultThreads(); }

    void readSliceAt(int z, std::span<std::byte> out) override {
        TESSERA_CHECK(z >= 0 && z < info_.extentVoxels.z && out.size() == sliceBytesOf(info_));
        const SliceSample sample = plan_.samples[static_cast<std::size_t>(z)];
        if (!plan_.resampled)
            return convert(sample.lower, out);
        const auto& lower = converted(sample.lower, sample.lower);
        if (sample.weight == 0) {
            std::copy(lower.begin(), lower.end(), out.begin());
            return;
        }
        const auto& upper = converted(sample.lower + 1, sample.lower);
        blendSlices(info_.type, lower, upper, sample.weight, out);
    }

  protected:
    /// Several at once, as far as there is room for what decoders take.
    void readSlicesAt(int first, int count, std::span<std::byte> out) override {
        constexpr std::size_t kMostDecoding = std::size_t{256} << 20;
        const std::size_t slice = sliceBytesOf(info_);
        TESSERA_CHECK(out.size() == slice * static_cast<std::size_t>(count));
        const auto workers = static_cast<int>(
            std::clamp<std::size_t>(kMostDecoding / decodingBytes(), 1, static_cast<std::size_t>(threads_)));
        if (plan_.resampled || workers == 1)
            return RandomSlabSource::readSlicesAt(first, count, out);
        std::vector<Found> found(static_cast<std::size_t>(count));
        std::vector<std::exception_ptr> refused(found.size());
        parallelFor(found.size(), workers, [&](std::size_t i) {
            const int n = plan_.samples[static_cast<std::size_t>(first) + i].lower;
            try {
                found[i] = decoded(n, out.subspan(i * slice, slice));
            } catch (const InputError&) {
                refused[i] = std::current_exception();
            }
        });
        for (std::size_t i = 0; i < found.size(); ++i) { // told as if read one after another
            if (refused[i])
                std::rethrow_exception(refused[i]);
            take(found[i]);
        }
    }

  private:
    using Slice = std::vector<std::byte>;
    /// What one slice told.
    struct Found {
        StreamFindings stream;
        std::uint64_t clamped = 0; // by slope and intercept
    };

    /// Of a slice: its stored numbers, the bytes of the file, and what decoders take.
    std::size_t decodingBytes() const {
        constexpr std::size_t kOfPixel = 20;
        return sliceBytesOf(info_) / bytesPerValue(info_.type) * kOfPixel;
    }
    void take(const Found& found) {
        findings_.add(found.stream);
        info_.lossy = info_.lossy || findings_.lossy;
        info_.clampedVoxels += found.stream.clamped + found.clamped;
    }

    /// The sorted slice n, cached with one other; `keep` is the one not to replace.
    const Slice& converted(int n, int keep) {
        for (Kept& kept : kept_)
            if (kept.slice == n)
                return kept.values;
        Kept& place = kept_[0].slice == keep ? kept_[1] : kept_[0];
        place.slice = -1; // stays so if reading throws
        place.values.resize(sliceBytesOf(info_));
        convert(n, place.values);
        place.slice = n;
        return place.values;
    }

    /// Reads the sorted slice n and converts it to physical values of the stored type.
    void convert(int n, std::span<std::byte> out) { take(decoded(n, out)); }
    Found decoded(int n, std::span<std::byte> out) const {
        const DicomSlice& slice =
            series_.slices[static_cast<std::size_t>(plan_.order[static_cast<std::size_t>(n)])];
        std::vector<std::int32_t> stored(static_cast<std::size_t>(slice.columns) *
                                         static_cast<std::size_t>(slice.rows));
        DicomPixels pixels;
        pixels.read(slice, stored);
        Found found{pixels.findings()};
        switch (info_.type) {
        case ValueType::i16:
            found.clamped = rescale<std::int16_t>(slice, stored, out);
            break;
        case ValueType::u16:
            found.clamped = rescale<std::uint16_t>(slice, stored, out);
            break;
        default:
            found.clamped = rescale<float>(slice, stored, out);
        }
        return found;
    }

    /// @return values that were clamped
    template <class T>
    std::uint64_t rescale(const DicomSlice& slice, std::span<const std::int32_t> stored,
                          std::span<std::byte> out) const {
        std::uint64_t clamped = 0;
        const double slope = slopeOf(slice), intercept = interceptOf(slice);
        for (std::size_t i = 0; i < stored.size(); ++i) {
            double value = slope * stored[i] + intercept; // exact for whole slope and intercept
            const bool isPadding =
                slice.paddingFirst && stored[i] >= *slice.paddingFirst && stored[i] <= *slice.paddingLast;
            if (isPadding && series_.isHounsfield && value < kAirHu)
                value = kAirHu;
            const double least = std::numeric_limits<T>::lowest(), most = std::numeric_limits<T>::max();
            if (value < least || value > most) {
                value = std::clamp(value, least, most);
                ++clamped;
            }
            const T typed = static_cast<T>(value);
            std::memcpy(out.data() + i * sizeof(T), &typed, sizeof(T));
        }
        return clamped;
    }

    struct Kept {
        int slice = -1;
        Slice values;
    };

    DicomSeries series_;
    SlicePlan plan_;
    VolumeInfo info_;
    std::string description_;
    StreamFindings findings_; // of all slices read so far
    int threads_ = 1;
    std::array<Kept, 2> kept_; // resampling only: the two neighbours
};

std::string shortNumber(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3f", value);
    return text;
}

std::string describeSource(const DicomSeries& series, const SlicePlan& plan, int number,
                           const VolumeInfo& info) {
    std::string text = std::to_string(series.slices.size()) +
                       (series.slices.size() == 1 ? " DICOM slice" : " DICOM slices") + ", series " +
                       std::to_string(number);
    if (!series.acquisition.modality.empty())
        text += ", " + series.acquisition.modality;
    if (std::abs(plan.tiltDegrees) > 0.05)
        text += ", gantry tilt " + shortNumber(plan.tiltDegrees) + " degrees";
    if (plan.resampled)
        text += ", interpolated along z to " + std::to_string(info.extentVoxels.z) + " even slices";
    const auto padded = std::any_of(series.slices.begin(), series.slices.end(), [](const DicomSlice& slice) {
        return slice.paddingFirst && slopeOf(slice) * *slice.paddingFirst + interceptOf(slice) < kAirHu;
    });
    if (series.isHounsfield && padded)
        text += ", declared padding below -1024 HU set to -1024 HU";
    return text;
}

std::size_t slicesOfFullest(const std::vector<DicomPhase>& phases) {
    std::size_t most = 0;
    for (const DicomPhase& phase : phases)
        most = std::max(most, phase.slices.size());
    return most;
}

/// "phase 50 %", with its number of slices if some are missing.
std::string labelOf(const DicomPhase& phase, const std::vector<DicomPhase>& phases) {
    const std::size_t most = slicesOfFullest(phases), own = phase.slices.size();
    return phase.label +
           (own < most ? " with " + std::to_string(own) + " of " + std::to_string(most) + " slices" : "");
}

/// "1: phase 0 %, 2: phase 50 %"
std::string listPhases(const std::vector<DicomPhase>& phases) {
    std::string text;
    for (std::size_t i = 0; i < phases.size(); ++i)
        text += (i == 0 ? "" : ", ") + std::to_string(i + 1) + ": " + labelOf(phases[i], phases);
    return text;
}

/// Keeps the slices of one phase, if there are several. A phase with fewer slices than another is refused,
/// unless allowMissing.
void choosePhase(DicomSeries& series, int wanted, bool allowMissing, const std::string& where) {
    const std::vector<DicomPhase> phases = phasesOf(series);
    const int count = static_cast<int>(phases.size());
    if (phases.empty() && wanted != 0)
        throw badFile(where, "several phases for --phase to choose from", "one image at each position");
    if (phases.empty())
        return;
    if (wanted < 1 || wanted > count)
        throw badFile(where,
                      wanted == 0 ? "one image at each position, or a choice with --phase N"
                                  : "--phase between 1 and " + std::to_string(count),
                      (wanted == 0 ? "" : std::to_string(wanted) + " of ") + std::to_string(count) +
                          " phases (" + listPhases(phases) + ")");
    const DicomPhase& chosen = phases[static_cast<std::size_t>(wanted) - 1];
    const std::size_t most = slicesOfFullest(phases);
    if (chosen.slices.size() < most && !allowMissing)
        throw badFile(where, std::to_string(most) + " slices in every phase",
                      std::to_string(chosen.slices.size()) + " in " + chosen.label +
                          "; --allow-missing takes it all the same");
    std::vector<DicomSlice> kept;
    for (const std::size_t i : chosen.slices)
        kept.push_back(series.slices[i]);
    series.slices = std::move(kept);
}

/// Slices without a position are left out with allowMissing.
std::size_t dropWithoutPosition(DicomSeries& series) {
    return std::erase_if(series.slices, [](const DicomSlice& slice) { return !slice.positionMm; });
}

/// "1 file", "2 files"
std::string counted(std::size_t number, const std::string& what) {
    return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

} // namespace

std::unique_ptr<SlabSource> openDicom(const DicomScan& scan, std::size_t index, const SourceOptions& options,
                                      const std::string& where) {
    std::size_t missing = couldBelong(scan, index).size();
    if (!options.allowMissing)
        requireComplete(scan, index);
    const int number = static_cast<int>(index) + 1;
    DicomSeries series = scan.series[index];
    if (options.allowMissing)
        missing += dropWithoutPosition(series);
    const std::size_t duplicates = dropDuplicates(series);
    choosePhase(series, options.phase, options.allowMissing, where);
    auto [plan, info] = checkedVolume(series, options.resampleZ, options.phase > 0, where);
    std::string description = describeSource(series, plan, number, info);
    if (options.phase > 0)
        description += ", --phase " + std::to_string(options.phase);
    if (duplicates > 0)
        description += ", " + counted(duplicates, "byte-identical duplicate") + " dropped";
    if (missing > 0)
        description += ", " + counted(missing, "file") + " left out that could be slices";
    return std::make_unique<DicomSource>(std::move(series), std::move(plan), std::move(info),
                                         std::move(description));
}

DicomListing listDicom(const DicomScan& scan, std::size_t index, bool allowMissing) {
    DicomListing listing;
    DicomSeries series = scan.series[index];
    listing.missing = couldBelong(scan, index).size();
    if (allowMissing)
        listing.missing += dropWithoutPosition(series);
    listing.duplicates = dropDuplicates(series);
    const std::vector<DicomPhase> phases = phasesOf(series);
    for (const DicomPhase& phase : phases)
        listing.phases.push_back(labelOf(phase, phases));
    if (!phases.empty())
        choosePhase(series, 1, true, "");
    listing.slices = static_cast<int>(series.slices.size());
    const auto tryWith = [&](bool resampleZ) {
        const auto [plan, info] = checkedVolume(series, resampleZ, !phases.empty(), "");
        listing.info = info;
        listing.tiltDegrees = plan.tiltDegrees;
    };
    try {
        tryWith(false);
    } catch (const InputError& refused) {
        listing.problem = "refused: " + withoutPath(refused);
        try {
            tryWith(true);
            listing.problem = "uneven slices: --resample-z interpolates them";
        } catch (const InputError&) { // not a volume either way
        }
    }
    return listing;
}

} // namespace tessera
