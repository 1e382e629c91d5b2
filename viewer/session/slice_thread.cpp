// viewer/session/slice_thread.cpp: see slice_thread.h.
#include "viewer/session/slice_thread.h"

#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/contract/sampler.h"
#include "viewer/session/slice_views.h"

#include <chrono>
#include <exception>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <utility>

namespace tessera {
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
    : store_(store), threads_(threads), news_(std::move(news)),
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

void SliceThread::draw(const SliceWish& wish, int coarser) {
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
        plane.display =
            greyPixels(sliceValues(cache_, info, plane.frame, plane.level, threads_), wish.window);
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
