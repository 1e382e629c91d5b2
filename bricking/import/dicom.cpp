// bricking/import/dicom.cpp: see dicom.h.
#include "bricking/import/dicom.h"

#include "bricking/import/dicom_geometry.h"
#include "bricking/import/dicom_pixels.h"
#include "bricking/import/random_slab_source.h"
#include "core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
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
    for (const DicomSlice& slice : series.slices)
        if (slopeOf(slice) == 0)
            throw badFile(where, "a rescale slope other than 0", "0 in " + slice.file.filename().string());
}

/// A slice whose header is built or filled in another way than most others' is damaged; where most are so, it
/// is the writer's habit. Returns what to say of such a habit.
std::string checkRegular(const DicomSeries& series) {
    const auto alike = [&](const auto& isOdd, const std::string& expected, const auto& found) {
        const auto odd = std::count_if(series.slices.begin(), series.slices.end(), isOdd);
        if (odd == 0 || 2 * odd > static_cast<std::ptrdiff_t>(series.slices.size()))
            return odd > 0;
        const DicomSlice& first = *std::find_if(series.slices.begin(), series.slices.end(), isOdd);
        throw badFile(first.file.string(), expected, found(first));
    };
    const bool habit = alike([](const DicomSlice& s) { return !s.irregularity.empty(); },
                             "a header without fault, as most slices of its series have",
                             [](const DicomSlice& s) { return s.irregularity; });
    const auto nothing = [](const DicomSlice&) { return std::string("none"); };
    alike([](const DicomSlice& s) { return !s.slope; }, "a rescale slope, as most slices have", nothing);
    alike([](const DicomSlice& s) { return !s.intercept; }, "a rescale intercept, as most slices have",
          nothing);
    if (!habit)
        return "";
    const DicomSlice& first = *std::find_if(series.slices.begin(), series.slices.end(),
                                            [](const DicomSlice& s) { return !s.irregularity.empty(); });
    return "irregular headers, in most slices alike (" + first.irregularity + "): read all the same";
}

/// Scanners give all slices of a CT one rescale; where they differ, a header may be damaged.
std::string noteRescale(const DicomSeries& series) {
    const DicomSlice& first = series.slices.front();
    const auto other = std::find_if(series.slices.begin(), series.slices.end(), [&](const DicomSlice& s) {
        return slopeOf(s) != slopeOf(first) || interceptOf(s) != interceptOf(first);
    });
    if (!series.isHounsfield || other == series.slices.end())
        return "";
    return "slices of one CT with different rescale, first in " + other->file.filename().string() +
           ": each is read by its own";
}

VolumeInfo describeVolume(const DicomSeries& series, const SlicePlan& plan, const std::string& where) {
    const DicomSlice& first = series.slices[static_cast<std::size_t>(plan.order.front())];
    VolumeInfo info;
    info.extentVoxels = {first.columns, first.rows, static_cast<int>(plan.samples.size())};
    info.type = chooseType(series);
    info.unit = series.isHounsfield ? "HU" : "";
    info.patientFromVoxel = plan.patientFromVoxel;
    info.acquisition = series.acquisition;
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
    info.validate(where);
    return info;
}

class DicomSource final : public RandomSlabSource {
  public:
    DicomSource(DicomSeries series, SlicePlan plan, VolumeInfo info, std::string description)
        : series_(std::move(series)), plan_(std::move(plan)), info_(std::move(info)),
          description_(std::move(description)), habit_(checkRegular(series_)),
          rescale_(noteRescale(series_)) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return description_; }

    std::vector<std::string> notes() const override {
        const StreamFindings& findings = pixels_.findings();
        std::vector<std::string> lines;
        for (const std::string* line : {&habit_, &rescale_, &findings.disagreement, &findings.mended})
            if (!line->empty())
                lines.push_back(*line);
        return lines;
    }

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
        switch (info_.type) {
        case ValueType::i16:
            return blend<std::int16_t>(lower, upper, sample.weight, out);
        case ValueType::u16:
            return blend<std::uint16_t>(lower, upper, sample.weight, out);
        default:
            return blend<float>(lower, upper, sample.weight, out);
        }
    }

  private:
    using Slice = std::vector<std::byte>;

    /// The sorted slice n, kept with one other; `keep` is the one not to be replaced.
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

    template <class T>
    static void blend(const Slice& lower, const Slice& upper, float weight, std::span<std::byte> out) {
        for (std::size_t at = 0; at < out.size(); at += sizeof(T)) {
            T a, b;
            std::memcpy(&a, lower.data() + at, sizeof(T));
            std::memcpy(&b, upper.data() + at, sizeof(T));
            const double mixed =
                static_cast<double>(a) + weight * (static_cast<double>(b) - static_cast<double>(a));
            const T value = static_cast<T>(std::is_integral_v<T> ? std::nearbyint(mixed) : mixed);
            std::memcpy(out.data() + at, &value, sizeof(T));
        }
    }

    /// Reads the sorted slice n and brings it to physical values of the stored type.
    void convert(int n, std::span<std::byte> out) {
        const DicomSlice& slice =
            series_.slices[static_cast<std::size_t>(plan_.order[static_cast<std::size_t>(n)])];
        stored_.resize(static_cast<std::size_t>(slice.columns) * static_cast<std::size_t>(slice.rows));
        const std::uint64_t clampedBefore = pixels_.findings().clamped;
        pixels_.read(slice, stored_);
        info_.lossy = info_.lossy || pixels_.findings().lossy;
        info_.clampedVoxels += pixels_.findings().clamped - clampedBefore;
        switch (info_.type) {
        case ValueType::i16:
            return rescale<std::int16_t>(slice, out);
        case ValueType::u16:
            return rescale<std::uint16_t>(slice, out);
        default:
            return rescale<float>(slice, out);
        }
    }

    template <class T> void rescale(const DicomSlice& slice, std::span<std::byte> out) {
        const double slope = slopeOf(slice), intercept = interceptOf(slice);
        for (std::size_t i = 0; i < stored_.size(); ++i) {
            double value = slope * stored_[i] + intercept; // exact for whole slope and intercept
            const bool isPadding =
                slice.paddingFirst && stored_[i] >= *slice.paddingFirst && stored_[i] <= *slice.paddingLast;
            if (isPadding && series_.isHounsfield && value < kAirHu)
                value = kAirHu;
            const double least = std::numeric_limits<T>::lowest(), most = std::numeric_limits<T>::max();
            if (value < least || value > most) {
                value = std::clamp(value, least, most);
                ++info_.clampedVoxels;
            }
            const T typed = static_cast<T>(value);
            std::memcpy(out.data() + i * sizeof(T), &typed, sizeof(T));
        }
    }

    struct Kept {
        int slice = -1;
        Slice values;
    };

    DicomSeries series_;
    SlicePlan plan_;
    VolumeInfo info_;
    std::string description_, habit_, rescale_; // the last two: notes
    DicomPixels pixels_;
    std::vector<std::int32_t> stored_; // one slice
    std::array<Kept, 2> kept_;         // resampling only: the two neighbours
};

std::string shortNumber(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3f", value);
    return text;
}

/// "series 2: CT, 134 slices of 512 x 512, 1.074 x 1.074 x 3.000 mm": nothing that identifies.
std::string describeSeries(const DicomSeries& series, int number) {
    const DicomSlice& first = series.slices.front();
    std::string text = "series " + std::to_string(number) + ": ";
    text += (series.acquisition.modality.empty() ? "unknown modality" : series.acquisition.modality) + ", " +
            std::to_string(series.slices.size()) + " slices of " + std::to_string(first.columns) + " x " +
            std::to_string(first.rows);
    try {
        const SlicePlan plan = planSlices(series, false, "");
        const glm::dmat4& affine = plan.patientFromVoxel;
        for (int axis = 0; axis < 3; ++axis)
            text += (axis == 0 ? ", " : " x ") + shortNumber(glm::length(glm::dvec3(affine[axis])));
        return text + " mm";
    } catch (const InputError&) {
        return text + ", no even spacing";
    }
}

std::string describeSource(const DicomSeries& series, const SlicePlan& plan, int number,
                           const VolumeInfo& info) {
    std::string text =
        std::to_string(series.slices.size()) + " DICOM slices, series " + std::to_string(number);
    if (!series.acquisition.modality.empty())
        text += ", " + series.acquisition.modality;
    if (plan.tiltDegrees > 0.05)
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

int chooseSeries(const DicomScan& scan, int wanted, const std::string& where) {
    const int count = static_cast<int>(scan.series.size());
    if (count == 0 && scan.imagesWithoutPlace > 0)
        throw badFile(where, "DICOM slices of a volume",
                      std::to_string(scan.imagesWithoutPlace) +
                          " images without a position in the patient or not of single values");
    if (count == 0)
        throw badFile(where, "DICOM slices", std::to_string(scan.otherFiles) + " files of other kinds");
    if (wanted == 0 && count == 1)
        return 1;
    if (wanted >= 1 && wanted <= count)
        return wanted;
    std::string list;
    for (int i = 0; i < count; ++i)
        list += (i == 0 ? "" : "; ") + describeSeries(scan.series[static_cast<std::size_t>(i)], i + 1);
    if (wanted == 0)
        throw badFile(where, "one DICOM series, or a choice with --series N",
                      std::to_string(count) + " series (" + list + ")");
    throw badFile(where, "--series between 1 and " + std::to_string(count),
                  std::to_string(wanted) + " (" + list + ")");
}

} // namespace

std::unique_ptr<SlabSource> openDicom(const std::filesystem::path& fileOrFolder, int wanted, bool resampleZ) {
    DicomScan scan = scanDicom(fileOrFolder);
    if (!scan.damaged.empty()) {
        const DamagedDicom& first = scan.damaged.front();
        throw badFile(first.file.string(), first.expected, first.found);
    }
    const std::string where = fileOrFolder.string();
    const int number = chooseSeries(scan, wanted, where);
    DicomSeries& series = scan.series[static_cast<std::size_t>(number - 1)];
    checkRescale(series, where);
    SlicePlan plan = planSlices(series, resampleZ, where);
    VolumeInfo info = describeVolume(series, plan, where);
    std::string description = describeSource(series, plan, number, info);
    return std::make_unique<DicomSource>(std::move(series), std::move(plan), std::move(info),
                                         std::move(description));
}

std::vector<DicomListing> listDicom(const std::filesystem::path& fileOrFolder) {
    std::vector<DicomListing> found;
    const DicomScan scan = scanDicom(fileOrFolder);
    for (std::size_t i = 0; i < scan.series.size(); ++i) {
        try {
            const SlicePlan plan = planSlices(scan.series[i], true, "");
            found.push_back({static_cast<int>(i) + 1, describeVolume(scan.series[i], plan, "")});
        } catch (const InputError&) { // not a volume: left out
        }
    }
    return found;
}

} // namespace tessera
