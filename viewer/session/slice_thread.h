// viewer/session/slice_thread.h: draws the three planes on a thread of its own, the latest request first. It
// draws a coarse level first if that is faster, then the level of a pixel's size.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "render/labels/slice_labels.h"
#include "viewer/session/view_geometry.h"

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace tessera {

// Planes through a volume: samples of the contract's field at screen resolution, read through a cache.

/// The finest level that a pixel can show of such a plane, made coarser until at most `chunks` chunks are
/// needed.
int sliceLevel(const VolumeInfo& info, const SliceFrame& frame, std::size_t chunks);

/// The plane's values at pixel centres, physical units, row by row: trilinear interpolation of the level's
/// samples. NaN outside the volume. Throws what decoding threw.
std::vector<float> sliceValues(BrickCache& cache, const VolumeInfo& info, const SliceFrame& frame, int level,
                               int threads);

/// Greys of a window as display values, in the layout of displayPixels(); black outside the volume.
std::vector<std::uint32_t> greyPixels(const std::vector<float>& values, const GreyWindow& window);

/// The same with labels over them.
std::vector<std::uint32_t> labelledPixels(const std::vector<float>& values, const GreyWindow& window,
                                          SliceLabels& labels, const VolumeInfo& info,
                                          const SliceFrame& frame, int threads);

class SliceThread {
  public:
    /// @param ram  its free bytes, less a part for pictures and labels, are for the cache of chunks; like
    /// store, it outlives this
    /// @param news  called from the thread when shown() has changed, or after an error
    SliceThread(const StoreReader& store, MemoryBudget& ram, int threads, std::function<void()> news);
    ~SliceThread();
    void show(const SliceWish& wish);
    /// Null before the first.
    std::shared_ptr<const ShownSlices> shown() const;
    /// The error since the last call; empty: none.
    std::string takeProblem();
    /// RAM of the smallest cache.
    static std::size_t floorBytes(const VolumeInfo& info, int threads);

  private:
    void run();
    void draw(const SliceWish& wish, int coarser);
    bool hasNewWish() const;
    SliceLabels* labelsOf(const SliceWish& wish);

    const StoreReader& store_;
    MemoryBudget& ram_;
    const int threads_;
    const std::function<void()> news_;
    BrickCache cache_;
    std::unique_ptr<SliceLabels> labels_;   // of the last request with labels
    std::shared_ptr<const Labels> refused_; // that could not be opened
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    bool stop_ = false;
    std::optional<SliceWish> wish_;
    std::optional<SliceWish> asked_; // the last request, waiting, being drawn or shown; none if it failed
    std::shared_ptr<const ShownSlices> shown_;
    std::string problem_;
    std::thread thread_; // last: it uses all of the above
};

} // namespace tessera
