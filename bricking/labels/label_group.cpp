// bricking/labels/label_group.cpp: see label_group.h.
#include "bricking/labels/label_group.h"

#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/threads.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kPartVoxels = std::size_t{1} << 19; // of a layer, read at once
constexpr std::size_t kLayerBytes = std::size_t{192}
                                    << 10; // a file that is open: zlib's window, read buffers

std::size_t threadsFor(std::size_t layers, int threads) {
    return std::min(layers, static_cast<std::size_t>(threads > 0 ? threads : defaultThreads()));
}

std::size_t sliceVoxels(const VolumeInfo& grid) {
    return cellCount({grid.extentVoxels.x, grid.extentVoxels.y, 1});
}

int partOf(const VolumeInfo& grid) {
    return static_cast<int>(std::clamp<std::size_t>(kPartVoxels / sliceVoxels(grid), 1,
                                                    static_cast<std::size_t>(grid.extentVoxels.z)));
}

} // namespace

std::uint32_t LabelNumbers::numberOf(std::uint32_t value) {
    if (value == lastValue_)
        return lastNumber_;
    const auto [at, isNew] = numbers_.try_emplace(value, static_cast<std::uint32_t>(values_.size()));
    if (isNew) {
        if (values_.size() == kMost)
            throw badFile(where_, "at most " + std::to_string(kMost) + " distinct labels",
                          "more; is it a scan?");
        values_.push_back(value);
    }
    lastValue_ = value;
    lastNumber_ = at->second;
    return lastNumber_;
}

void spoolNumbers(SpoolFile& spool, std::span<const std::uint32_t> numbers,
                  std::vector<std::uint16_t>& scratch) {
    scratch.resize(numbers.size());
    std::transform(numbers.begin(), numbers.end(), scratch.begin(),
                   [](std::uint32_t number) { return static_cast<std::uint16_t>(number); });
    spool.append(std::as_bytes(std::span(std::as_const(scratch))));
}

void LabelGroup::checkCombinations() const {
    if (combinations_.size() > kMostCombinations)
        throw badFile(labels_.where(), "at most 65535 sets of labels that share voxels", "more");
}

LabelGroup::LabelGroup(std::vector<LabelLayer*> layers, LabelNumbers& labels, MemoryBudget& ram, int threads,
                       std::filesystem::path scratch)
    : layers_(std::move(layers)), labels_(labels), threads_(threads), scratch_(std::move(scratch)),
      combinations_(ram, labels.where()), part_(partOf(info())),
      charge_(ram.charge(bytesNeeded(layers_, threads), "reading layers of labels")) {
    const bool areAlone =
        std::ranges::all_of(layers_, [](const LabelLayer* layer) { return layer->isAlone(); });
    buffers_.resize(areAlone ? threadsFor(layers_.size(), threads_) : 1);
    for (auto& buffer : buffers_)
        buffer.resize(sliceVoxels(info()) * static_cast<std::size_t>(part_));
}

std::size_t LabelGroup::bytesNeeded(std::span<LabelLayer* const> all, int threads) {
    const VolumeInfo& grid = all.front()->info();
    const std::size_t layers = all.size();
    std::size_t reading = 0;
    for (const LabelLayer* layer : all)
        reading += layer->bytesToRead();
    const std::size_t part = sliceVoxels(grid) * static_cast<std::size_t>(partOf(grid));
    const std::size_t before =
        layers > kMostOpen ? part * (sizeof(std::uint32_t) + sizeof(std::uint16_t)) : 0;
    return threadsFor(layers, threads) * part * sizeof(std::uint32_t) + before +
           std::min(layers, kMostOpen) * kLayerBytes + reading;
}

void LabelGroup::readSlices(int count, std::span<std::uint32_t> out) {
    TESSERA_CHECK(out.size() == sliceVoxels(info()) * static_cast<std::size_t>(count));
    if (nextZ_ == 0)
        spoolAllButLast();
    for (int done = 0; done < count;) {
        const int slices = std::min(part_, count - done);
        const auto part = out.subspan(sliceVoxels(info()) * static_cast<std::size_t>(done),
                                      sliceVoxels(info()) * static_cast<std::size_t>(slices));
        readPart(slices, part);
        addLayers(next_, layers_.size(), slices, part);
        done += slices;
        nextZ_ += slices;
    }
}

/// What the layers before next_ have in the slices from nextZ_ on.
void LabelGroup::readPart(int count, std::span<std::uint32_t> out) {
    std::fill(out.begin(), out.end(), 0u);
    if (!before_)
        return;
    std::vector<std::uint16_t> numbers(out.size());
    before_->readAt(static_cast<std::uint64_t>(nextZ_) * sliceVoxels(info()) * sizeof(std::uint16_t),
                    std::as_writable_bytes(std::span(numbers)));
    TESSERA_CHECK(numbers.size() == sliceVoxels(info()) * static_cast<std::size_t>(count));
    std::copy(numbers.begin(), numbers.end(), out.begin());
}

void LabelGroup::addLayers(std::size_t first, std::size_t end, int count, std::span<std::uint32_t> out) {
    for (; first < end; first += buffers_.size()) {
        checkInterrupted();
        const std::size_t layers = std::min(buffers_.size(), end - first);
        parallelFor(layers, threads_, [&](std::size_t i) {
            layers_[first + i]->readSlices(count, std::span(buffers_[i]).first(out.size()));
        });
        for (std::size_t i = 0; i < layers; ++i) {
            const auto layer = static_cast<std::uint32_t>(first + i) << 16;
            // Neighbours are mostly alike.
            std::uint32_t value = 0, before = 0, entry = 0, after = 0;
            for (std::size_t at = 0; at < out.size(); ++at) {
                const std::uint32_t now = buffers_[i][at];
                if (now == 0)
                    continue;
                if (now != value || out[at] != before) {
                    entry = layer | labels_.numberOf(now);
                    before = out[at];
                    after = combinations_.with(before, entry);
                    value = now;
                }
                out[at] = after;
            }
        }
    }
}

void LabelGroup::spoolAllButLast() {
    std::vector<std::uint32_t> part;
    std::vector<std::uint16_t> scratch;
    while (layers_.size() - next_ > kMostOpen) {
        auto spool = std::make_unique<SpoolFile>(scratch_);
        for (nextZ_ = 0; nextZ_ < info().extentVoxels.z;) {
            const int slices = std::min(part_, info().extentVoxels.z - nextZ_);
            part.resize(sliceVoxels(info()) * static_cast<std::size_t>(slices));
            readPart(slices, part);
            addLayers(next_, next_ + kMostOpen, slices, part);
            checkCombinations();
            spoolNumbers(*spool, part, scratch);
            nextZ_ += slices;
        }
        nextZ_ = 0;
        next_ += kMostOpen;
        before_ = std::move(spool);
    }
}

} // namespace tessera
