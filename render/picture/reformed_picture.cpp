// render/picture/reformed_picture.cpp: see reformed_picture.h.
#include "render/picture/reformed_picture.h"

#include "bricking/cache/brick_cache.h"
#include "bricking/statistics/statistics.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/base/threads.h"
#include "core/scene/mode.h"
#include "core/scene/preset.h"
#include "core/scene/reformed_sheet.h" // sizeOf
#include "render/contract/lattice.h"
#include "render/contract/sampler.h"
#include "render/labels/reformed_places.h"
#include "render/labels/slice_labels.h"
#include "render/plan/drawn_part.h"
#include "render/plan/frame_plan.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

constexpr glm::ivec2 kPatch{64, 16}; // pixels that a thread draws together: few chunks at a time
constexpr double kSlabStepVoxels = 0.5;
/// Folded pixels are hatched: air is black, too.
constexpr int kHatchPixels = 8;
constexpr glm::vec4 kHatch{0.12F, 0.12F, 0.12F, 1};

/// What turns a place into a colour.
struct ReformedLook {
    const VolumeInfo& info;
    glm::dmat4 voxelFromPatient;
    DrawnPart part;
    ValueLook look;
    TransferFunction function;
    Reduction reduction = Reduction::average;
    double thicknessMm = 0;
};

/// The value of a place, or of the slab there; none outside the drawn part. Physical units.
/// @param voxel, through  the place, and the slab's whole thickness through it: voxels
std::optional<double> valueOfPlace(const ReformedLook& look, LatticeReader& samples, const glm::dvec3& voxel,
                                   const glm::dvec3& through) {
    const VolumeInfo& info = look.info;
    const glm::dvec3 extent(info.extentVoxels);
    const int layers = look.thicknessMm > 0
                           ? std::max(1, static_cast<int>(std::ceil(glm::length(through) / kSlabStepVoxels)))
                           : 1;
    std::optional<double> kept;
    int met = 0;
    for (int n = 0; n < layers; ++n) {
        const glm::dvec3 at = voxel + ((n + 0.5) / layers - 0.5) * through;
        if (glm::clamp(at, glm::dvec3(0), extent) != at || (look.part.any() && !look.part.keeps(at, 0)))
            continue;
        const double value = info.rescaleSlope * fieldValue(samples, at, 1.0) + info.rescaleIntercept;
        ++met;
        if (!kept)
            kept = value;
        else if (look.reduction == Reduction::maximum)
            kept = std::max(*kept, value);
        else if (look.reduction == Reduction::minimum)
            kept = std::min(*kept, value);
        else
            kept = *kept + value;
    }
    if (kept && look.reduction == Reduction::average)
        kept = *kept / met;
    return kept;
}

/// Draws one patch of one picture.
/// @param first  of the picture's pixels
void drawPatch(const ReformedLook& look, LatticeReader& samples, const Reformation& picture,
               const glm::ivec2& first, Image& image, ReformedShare& share) {
    const glm::ivec2 end = glm::min(first + kPatch, picture.size());
    const glm::dmat3 direction(look.voxelFromPatient);
    const double step = picture.mmPerPixel / picture.samples;
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) {
            glm::dvec4 sum(0);
            int folded = 0;
            for (int j = 0; j < picture.samples; ++j) {
                const ReformedRow& row =
                    picture.rows[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.samples) +
                                 static_cast<std::size_t>(j)];
                const glm::dvec3 through = direction * (look.thicknessMm * row.towards);
                for (int i = 0; i < picture.samples; ++i) {
                    const double mm = (x * picture.samples + i + 0.5) * step;
                    if (row.folds(mm)) {
                        ++folded;
                        continue;
                    }
                    const glm::dvec3 voxel(look.voxelFromPatient * glm::dvec4(row.place(mm), 1));
                    if (const auto value = valueOfPlace(look, samples, voxel, through))
                        sum += glm::dvec4(colourOfValue(look.look, look.function, *value), 1);
                }
            }
            const int all = picture.samples * picture.samples;
            glm::vec4& pixel = image.pixels[static_cast<std::size_t>(picture.from.y + y) *
                                                static_cast<std::size_t>(image.size.x) +
                                            static_cast<std::size_t>(picture.from.x + x)];
            pixel = glm::vec4(sum / static_cast<double>(all));
            if (folded == all && (x + y) % kHatchPixels == 0)
                pixel = kHatch;
            ++share.pixels;
            share.folded += folded == all ? 1 : 0;
            share.outside += folded < all && sum.a == 0 ? 1 : 0;
        }
}

struct Patch {
    std::size_t picture;
    glm::ivec2 first; // of its pixels
};
/// Lays the labels over all pictures.
/// @return  what of them shows
RenderResult::Labels layLabelsOver(SliceLabels& labels, const std::vector<Reformation>& pictures,
                                   const VolumeInfo& info, Image& image) {
    RenderResult::Labels report;
    report.all = labels.table().labels.size();
    report.shown = labels.shownLabels();
    std::set<std::uint32_t> met;
    for (const Reformation& picture : pictures) {
        const ReformedPlaces places(picture, info);
        const auto rowOf = [&](int y) {
            return image.pixels.begin() + static_cast<std::ptrdiff_t>(picture.from.y + y) * image.size.x +
                   picture.from.x;
        };
        Image part(picture.size());
        for (int y = 0; y < part.size.y; ++y)
            std::copy_n(rowOf(y), part.size.x,
                        part.pixels.begin() + static_cast<std::ptrdiff_t>(y) * part.size.x);
        const SliceLabels::Drawn drawn = labels.layOver(part.pixels, places);
        for (int y = 0; y < part.size.y; ++y)
            std::copy_n(part.pixels.begin() + static_cast<std::ptrdiff_t>(y) * part.size.x, part.size.x,
                        rowOf(y));
        met.insert(drawn.values.begin(), drawn.values.end());
        report.level = std::max(report.level, drawn.level);
    }
    report.onSlice.emplace_back(met.begin(), met.end());
    return report;
}

/// Bytes of the largest picture, which labels are laid over by itself.
std::size_t largestBytes(const std::vector<Reformation>& pictures) {
    std::size_t most = 0;
    for (const Reformation& picture : pictures)
        most = std::max(most, static_cast<std::size_t>(picture.size().x) *
                                  static_cast<std::size_t>(picture.size().y));
    return most * sizeof(glm::vec4);
}

/// In the order that they are drawn in: pictures along the line go on together, band by band, for they lie in
/// the same chunks; cross-sections one after another.
std::vector<Patch> patchesOf(const std::vector<Reformation>& pictures) {
    std::vector<Patch> patches;
    std::size_t n = 0;
    while (n < pictures.size()) {
        std::size_t end = n + 1;
        while (!pictures[n].isSection && end < pictures.size() && !pictures[end].isSection)
            ++end;
        int height = 0;
        for (std::size_t i = n; i < end; ++i)
            height = std::max(height, pictures[i].size().y);
        for (int y = 0; y < height; y += kPatch.y)
            for (std::size_t i = n; i < end; ++i)
                for (int x = 0; x < pictures[i].columns && y < pictures[i].size().y; x += kPatch.x)
                    patches.push_back({i, {x, y}});
        n = end;
    }
    return patches;
}

TransferFunction functionOfValues(const SceneVolume& volume, const ValueSummary& values) {
    const auto* const name = std::get_if<std::string>(&volume.transferFunction);
    return name ? presetFunction(*name, values) : std::get<TransferFunction>(volume.transferFunction);
}

} // namespace

RenderResult renderReformed(const Scene& scene, const std::vector<Reformation>& pictures,
                            const StoreReader& store, MemoryBudget& ram, const RenderOptions& options,
                            ReformedShare& share) {
    if (scene.volumes.size() != 1)
        throw badFile("volumes", "one where a line is reformed", std::to_string(scene.volumes.size()));
    const glm::ivec2 size = sizeOf(pictures);
    TESSERA_CHECK(size.x > 0 && size.y > 0);
    Progress nobody;
    Progress& progress = options.progress ? *options.progress : nobody;
    RenderResult result;
    result.engine = EngineKind::native;
    result.engineReason = "reformations are drawn without rays";
    result.device = "CPU";
    result.levelsOnPurpose = true;
    result.pixels.asked = pictures.front().samples * pictures.front().samples;
    result.pixels.taken = result.pixels.most = result.pixels.asked;

    const auto start = std::chrono::steady_clock::now();
    progress.stage("reading statistics");
    const Charge ofPicture =
        ram.charge(sizeof(glm::vec4) * static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y),
                   "the picture");
    const VolumeInfo& info = store.info();
    Scene ofCuts = scene;
    ofCuts.mode = Mode::composite; // the plane of a slice does not count
    ReformedLook look{info, glm::inverse(info.patientFromVoxel), drawnPart(ofCuts, info), {}, {}};
    {
        const Statistics statistics = loadStatistics(store, ram, options.threads);
        const ValueSummary values = summarise(statistics, info, scene.volumes.front().unit);
        look.look = {scene.valueColour, windowOf(scene.window, values, Mode::slice)};
        look.function = functionOfValues(scene.volumes.front(), values);
        result.window = look.look.window;
        result.lowest = values.lowest;
        result.highest = values.highest;
        Scene ofWindow = ofCuts;
        ofWindow.mode = Mode::slice;
        result.leftOut = fillsLeftOut(ofWindow, values);
    }
    look.reduction = scene.slice.reduction;
    look.thicknessMm = scene.slice.thicknessMm;
    result.secondsPreparing = secondsSince(start);

    // They take their share before the cache.
    std::optional<SliceLabels> labels;
    std::optional<Charge> ofLabels;
    if (const Labels& asked = scene.volumes.front().labels; !asked.path.empty()) {
        labels.emplace(asked, info, ram, options.threads, asked.place());
        ofLabels.emplace(ram.charge(largestBytes(pictures), "a picture that labels are laid over"));
    }
    progress.stage("drawing");
    const auto drawing = std::chrono::steady_clock::now();
    // All that is free, up to what holds the chunks of a band of any picture for every thread.
    constexpr std::size_t kEnough = std::size_t{256} << 20;
    const std::size_t floor = latticeCacheFloorBytes(info, options.threads);
    BrickCache cache(store, ram, std::max(floor, std::min(kEnough, ram.freeBytes())), options.threads);
    result.image = Image(size);
    const std::vector<Patch> patches = patchesOf(pictures);
    std::atomic<std::size_t> pixels{0}, outside{0}, folded{0};
    parallelFor(
        patches.size(), options.threads,
        [&](std::size_t n) {
            const Patch& patch = patches[n];
            LatticeReader samples(cache, info, 0, nullptr);
            ReformedShare own;
            drawPatch(look, samples, pictures[patch.picture], patch.first, result.image, own);
            pixels += own.pixels;
            outside += own.outside;
            folded += own.folded;
        },
        [&](double part) { progress.update(part); });
    if (labels)
        result.labels = layLabelsOver(*labels, pictures, info, result.image);
    share = {pixels, outside, folded};
    result.secondsDrawing = secondsSince(drawing);
    return result;
}

} // namespace tessera
