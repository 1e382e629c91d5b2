// viewer/session/slice_thread.cpp: see slice_thread.h.
#include "viewer/session/slice_thread.h"

#include "core/base/error.h"
#include "core/base/threads.h"
#include "core/image/colour.h"
#include "core/image/image.h"
#include "render/contract/lattice.h"
#include "render/contract/sampler.h"
#include "viewer/session/shown_picture.h" // displayPixels

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <utility>

namespace tessera {
namespace {

constexpr int kTile = 32; // pixels along a tile: few chunks at a time

} // namespace

int sliceLevel(const VolumeInfo& info, const SliceFrame& frame, std::size_t chunks) {
    const glm::dmat3 voxelFromPatient = glm::inverse(glm::dmat3(info.patientFromVoxel));
    const glm::dvec3 right = frame.mmPerPixel * (voxelFromPatient * frame.pose.right),
                     up = frame.mmPerPixel * (voxelFromPatient * frame.pose.up);
    const double voxels = std::min(glm::length(right), glm::length(up)); // per pixel
    int level =
        std::clamp(static_cast<int>(std::floor(std::log2(std::max(1.0, voxels)))), 0, kLevelCount - 1);
    const glm::dvec3 along = static_cast<double>(frame.size.x) * glm::abs(right),
                     across = static_cast<double>(frame.size.y) * glm::abs(up);
    for (; level < kLevelCount - 1; ++level) {
        const double edge = static_cast<double>(kChunkExtent << level);
        const glm::dvec3 box = glm::min(along + across, glm::dvec3(info.extentVoxels)) / edge + 2.0;
        // A plane crosses at most as many chunks as the two longest sides of its box span; an oblique plane
        // at most twice as many.
        const double least = std::min({box.x, box.y, box.z});
        if (2 * box.x * box.y * box.z / least <= static_cast<double>(chunks))
            break;
    }
    return level;
}

std::vector<float> sliceValues(BrickCache& cache, const VolumeInfo& info, const SliceFrame& frame, int level,
                               int threads) {
    const glm::ivec2 size = frame.size;
    std::vector<float> values(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const double perVoxel = std::exp2(-level);
    const glm::dvec3 extent(info.extentVoxels);
    const glm::ivec2 tiles = (size + (kTile - 1)) / kTile;
    parallelFor(
        static_cast<std::size_t>(tiles.x) * static_cast<std::size_t>(tiles.y), threads, [&](std::size_t n) {
            LatticeReader samples(cache, info, level, nullptr);
            const glm::ivec2 first =
                kTile * glm::ivec2(static_cast<int>(n) % tiles.x, static_cast<int>(n) / tiles.x);
            const glm::ivec2 end = glm::min(first + kTile, size);
            for (int y = first.y; y < end.y; ++y)
                for (int x = first.x; x < end.x; ++x) {
                    const glm::dvec3 mm = frame.patientFromPicture({x + 0.5, y + 0.5});
                    const glm::dvec3 voxel(voxelFromPatient * glm::dvec4(mm, 1));
                    const bool inside = glm::clamp(voxel, glm::dvec3(0), extent) == voxel;
                    values[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                           static_cast<std::size_t>(x)] =
                        inside ? static_cast<float>(info.rescaleSlope * fieldValue(samples, voxel, perVoxel) +
                                                    info.rescaleIntercept)
                               : std::numeric_limits<float>::quiet_NaN();
                }
        });
    return values;
}

std::vector<std::uint32_t> greyPixels(const std::vector<float>& values, const GreyWindow& window) {
    std::vector<std::uint32_t> pixels(values.size());
    std::transform(values.begin(), values.end(), pixels.begin(), [&](float value) {
        const double part = (static_cast<double>(value) - window.low()) / window.width;
        const double grey = part > 0 ? std::min(part, 1.0) : 0.0; // NaN is black
        const auto code = static_cast<std::uint32_t>(std::lround(255 * grey));
        return code | code << 8 | code << 16 | 0xFF000000u;
    });
    return pixels;
}

std::vector<std::uint32_t> labelledPixels(const std::vector<float>& values, const GreyWindow& window,
                                          SliceLabels& labels, const VolumeInfo& info,
                                          const SliceFrame& frame, int threads) {
    Image image(frame.size);
    std::transform(values.begin(), values.end(), image.pixels.begin(), [&](float value) {
        if (std::isnan(value))
            return glm::vec4(0);
        const double part = std::clamp((static_cast<double>(value) - window.low()) / window.width, 0.0, 1.0);
        return glm::vec4(glm::vec3(static_cast<float>(linearFromSrgb(part))), 1);
    });
    labels.layOver(image.pixels, planePlaces(frame.pose, frame.mmPerPixel, info, frame.size));
    return displayPixels(image, glm::vec3(0), frame.size, threads);
}

namespace {

constexpr double kSoonMs = 40;    // a coarse picture before a fine one that takes longer
constexpr int kCoarser = 2;       // levels
constexpr std::size_t kParts = 8; // of the RAM, one is for pictures

double valueAt(BrickCache& cache, const VolumeInfo& info, const glm::dvec3& mm) {
    const glm::dvec3 voxel(glm::inverse(info.patientFromVoxel) * glm::dvec4(mm, 1));
    if (glm::clamp(voxel, glm::dvec3(0), glm::dvec3(info.extentVoxels)) != voxel)
        return std::numeric_limits<double>::quiet_NaN();
    LatticeReader samples(cache, info, 0, nullptr);
    return info.rescaleSlope * fieldValue(samples, voxel, 1.0) + info.rescaleIntercept;
}

} // namespace

std::size_t SliceThread::floorBytes(const VolumeInfo& info, int threads) {
    const auto used = static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
    const std::size_t chunk = cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info.type);
    return (LatticeReader::kPinnedChunks + 2) * used * chunk;
}

SliceThread::SliceThread(const StoreReader& store, MemoryBudget& ram, int threads, std::function<void()> news)
    : store_(store), ram_(ram), threads_(threads), news_(std::move(news)),
      cache_(store, ram,
             std::max(floorBytes(store.info(), threads), ram.freeBytes() - ram.freeBytes() / kParts),
             threads),
      thread_([this] { run(); }) {}

SliceThread::~SliceThread() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wake_.notify_all();
    thread_.join();
}

void SliceThread::show(const SliceWish& wish) {
    {
        const std::lock_guard lock(mutex_);
        if (asked_ && *asked_ == wish)
            return;
        wish_ = asked_ = wish;
    }
    wake_.notify_all();
}

std::shared_ptr<const ShownSlices> SliceThread::shown() const {
    const std::lock_guard lock(mutex_);
    return shown_;
}

std::string SliceThread::takeProblem() {
    const std::lock_guard lock(mutex_);
    return std::exchange(problem_, {});
}

bool SliceThread::hasNewWish() const {
    const std::lock_guard lock(mutex_);
    return stop_ || wish_.has_value();
}

/// Null: there are none, or they cannot be opened, which is told once.
SliceLabels* SliceThread::labelsOf(const SliceWish& wish) {
    if (!wish.labels || wish.labels == refused_)
        return nullptr;
    try {
        if (labels_ && labels_->labels().store != wish.labels->store)
            labels_.reset();
        if (!labels_)
            labels_ = std::make_unique<SliceLabels>(*wish.labels, store_.info(), ram_, threads_, "labels");
        else if (!(labels_->labels() == *wish.labels))
            labels_->setLooks(*wish.labels, "labels");
        return labels_.get();
    } catch (const Error& e) {
        refused_ = wish.labels;
        const std::lock_guard lock(mutex_);
        problem_ = std::string("the planes show no labels: ") + e.what();
        return nullptr;
    }
}

void SliceThread::draw(const SliceWish& wish, int coarser) {
    SliceLabels* const labels = labelsOf(wish);
    auto shown = std::make_shared<ShownSlices>();
    shown->wish = wish;
    shown->fine = coarser == 0;
    const VolumeInfo& info = store_.info();
    for (std::size_t n = 0; n < shown->planes.size(); ++n) {
        if (wish.sizes[n].x <= 0 || wish.sizes[n].y <= 0)
            continue;
        ShownSlice& plane = shown->planes[n];
        plane.frame = sliceFrame(info, static_cast<Orientation>(n), wish.placeMm, wish.sizes[n], wish.zoom);
        plane.level =
            std::min(sliceLevel(info, plane.frame, cache_.pinnableChunks()) + coarser, kLevelCount - 1);
        const std::vector<float> values = sliceValues(cache_, info, plane.frame, plane.level, threads_);
        plane.display = labels ? labelledPixels(values, wish.window, *labels, info, plane.frame, threads_)
                               : greyPixels(values, wish.window);
    }
    shown->value = valueAt(cache_, info, wish.placeMm);
    {
        const std::lock_guard lock(mutex_);
        shown_ = std::move(shown);
    }
    news_();
}

void SliceThread::run() {
    using Clock = std::chrono::steady_clock;
    double fineMs = 2 * kSoonMs; // the last fine picture
    for (;;) {
        SliceWish wish;
        {
            std::unique_lock lock(mutex_);
            wake_.wait(lock, [&] { return stop_ || wish_; });
            if (stop_)
                return;
            wish = *std::exchange(wish_, {});
        }
        try {
            if (fineMs > kSoonMs)
                draw(wish, kCoarser);
            if (hasNewWish())
                continue;
            const auto began = Clock::now();
            draw(wish, 0);
            fineMs = std::chrono::duration<double, std::milli>(Clock::now() - began).count();
        } catch (const std::exception& e) {
            {
                const std::lock_guard lock(mutex_);
                problem_ = e.what();
                if (!wish_)
                    asked_.reset(); // asked for again, it is tried again
            }
            news_();
        }
    }
}

} // namespace tessera
