// render/labels/slice_labels.cpp: see slice_labels.h.
#include "render/labels/slice_labels.h"

#include "bricking/labels/label_files.h"
#include "bricking/labels/label_volume.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/labels/outline_band.h"
#include "render/labels/set_reader.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

namespace tessera {
namespace {

constexpr int kParts = 4; // of a pixel along an axis
constexpr int kTile = 32; // pixels along a tile: few chunks at a time
/// The cache takes this part of what is free, and no more than that.
constexpr std::size_t kShareOfRam = 16, kMostCacheBytes = std::size_t{64} << 20;
/// A tile's places with the widest outline around it: sets, what has a label, distances, colours.
constexpr std::size_t kTileBytes = std::size_t{704} << 10;

std::size_t bytesOf(const SliceLooks& looks) {
    std::size_t bytes =
        looks.labels.size() * sizeof(SliceLooks::OneLabel) + looks.ofSet.size() * sizeof(std::uint16_t);
    for (const SliceLooks::Set& set : looks.sets)
        bytes += sizeof set + set.labels.size() * sizeof(std::uint16_t);
    return bytes;
}

std::vector<std::uint8_t> shownLabelsOf(const SliceLooks& looks) {
    std::vector<std::uint8_t> shown(looks.labels.size());
    for (const SliceLooks::Set& set : looks.sets)
        for (const std::uint16_t label : set.labels)
            shown[label] = 1;
    return shown;
}

/// Some pixel of a rectangle shows a part of the volume.
bool showsAny(std::span<const glm::vec4> pixels, const glm::ivec2& size, const glm::ivec2& first,
              const glm::ivec2& count) {
    for (int y = first.y; y < first.y + count.y; ++y) {
        const auto row = pixels.subspan(static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                                            static_cast<std::size_t>(first.x),
                                        static_cast<std::size_t>(count.x));
        if (std::any_of(row.begin(), row.end(), [](const glm::vec4& pixel) { return pixel.a > 0; }))
            return true;
    }
    return false;
}

} // namespace

/// A rectangle of pixels, and what one thread needs for it.
struct SliceLabels::Tile {
    const SurfacePlaces& places;
    SetReader sets;
    double outlineScale = 1;
    glm::ivec2 first{0}, count{0};      // pixels
    std::vector<LabelsOver> over = {};  // of them
    std::vector<std::uint8_t> met = {}; // of labels: some place has it
    // Work: parts of pixels, with the outlines' width around them.
    std::vector<std::uint16_t> owners = {};
    std::vector<std::uint8_t> inside = {};
    std::vector<glm::vec4> outlines = {}; // sums of colours times shares, and of shares
    OutlineBand band = {};
};

SliceLabels::SliceLabels(const Labels& labels, const VolumeInfo& scan, MemoryBudget& ram, int threads,
                         const std::string& where)
    : threads_(threads > 0 ? threads : defaultThreads()) {
    voxels_ = std::make_unique<StoreReader>(labels.store.empty() ? labels.path : labels.store, ram);
    own_ = readLabelTable(*voxels_, ram);
    requireSameGrid(*voxels_, scan);
    setLooks(labels, where);
    charge_ = ram.charge(2 * tessera::bytesOf(table_) + bytesOf(looks_) +
                             kTileBytes * static_cast<std::size_t>(threads_),
                         "labels over a slice");
    const std::size_t least = latticeCacheFloorBytes(voxels_->info(), threads_);
    cache_ = std::make_unique<BrickCache>(
        *voxels_, ram, std::max(least, std::min(ram.freeBytes() / kShareOfRam, kMostCacheBytes)), threads_);
}

void SliceLabels::setLooks(const Labels& labels, const std::string& where) {
    LabelTable named = namedLabels(own_, labels);
    looks_ = sliceLooks(named, labels, where);
    table_ = std::move(named);
    labels_ = labels;
}

std::size_t SliceLabels::shownLabels() const {
    const std::vector<std::uint8_t> shown = shownLabelsOf(looks_);
    return static_cast<std::size_t>(std::count(shown.begin(), shown.end(), 1));
}

int SliceLabels::levelOf(const SurfacePlaces& places) {
    const double voxels = std::clamp(places.voxelsPerPixel(), 1.0, std::exp2(kLevelCount - 1));
    constexpr double kRounding = 1e-6;
    // Places are a quarter of a pixel apart: every sample of the level below is met, too.
    return std::max(static_cast<int>(std::floor(std::log2(voxels) + kRounding)) - 1, 0);
}

void SliceLabels::draw(Tile& t) {
    t.over.assign(static_cast<std::size_t>(t.count.x) * static_cast<std::size_t>(t.count.y), {});
    if (!t.places.isMet)
        return;
    const double widest = kParts * looks_.widest * t.outlineScale;
    const int around = widest > 0 ? (OutlineBand::reach(widest) + kParts - 1) / kParts : 0; // pixels
    const glm::ivec2 size = kParts * (t.count + 2 * around), core(kParts * around);
    const auto wide = static_cast<std::size_t>(size.x);
    t.owners.resize(wide * static_cast<std::size_t>(size.y));
    bool any = false;
    std::size_t n = 0;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x, ++n) {
            const glm::dvec2 pixel = glm::dvec2(t.first - around) + (glm::dvec2(x, y) + 0.5) / double{kParts};
            const auto place = t.places.at(pixel);
            t.owners[n] = place ? t.sets.at(*place) : std::uint16_t{0};
            any = any || t.owners[n] != 0;
        }
    if (!any)
        return;
    const glm::ivec2 parts = kParts * t.count;
    const auto ownerAt = [&](int x, int y) {
        return t.owners[static_cast<std::size_t>(core.y + y) * wide + static_cast<std::size_t>(core.x + x)];
    };
    std::vector<std::uint16_t> there, labels; // sets in the raster; labels in the tile
    for (std::size_t i = 0; i < t.owners.size(); ++i)
        if (i == 0 || t.owners[i] != t.owners[i - 1])
            there.push_back(t.owners[i]);
    std::sort(there.begin(), there.end());
    there.erase(std::unique(there.begin(), there.end()), there.end());
    for (int y = 0; y < parts.y; ++y)
        for (int x = 0; x < parts.x; ++x)
            if (x == 0 || ownerAt(x, y) != ownerAt(x - 1, y))
                for (const std::uint16_t label : looks_.sets[ownerAt(x, y)].labels)
                    labels.push_back(label);
    std::sort(labels.begin(), labels.end());
    labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
    const auto across = static_cast<std::size_t>(parts.x);
    t.outlines.assign(across * static_cast<std::size_t>(parts.y), glm::vec4(0));
    for (const std::uint16_t label : labels) {
        t.met[label] = 1;
        const SliceLooks::OneLabel& look = looks_.labels[label];
        const double width = kParts * double{look.outline} * t.outlineScale;
        const auto has = [&](std::uint16_t set) {
            const auto& of = looks_.sets[set].labels;
            return std::binary_search(of.begin(), of.end(), label);
        };
        if (!(width > 0) || std::all_of(there.begin(), there.end(), has))
            continue;
        t.inside.resize(t.owners.size());
        std::uint16_t last = t.owners[0];
        std::uint8_t isIn = has(last) ? 1 : 0;
        for (std::size_t i = 0; i < t.owners.size(); ++i) {
            if (t.owners[i] != last) {
                last = t.owners[i];
                isIn = has(last) ? 1 : 0;
            }
            t.inside[i] = isIn;
        }
        const std::vector<float>& band = t.band.of(t.inside, size, core, parts, width);
        for (std::size_t i = 0; i < band.size(); ++i)
            t.outlines[i] += band[i] * glm::vec4(look.colour, 1);
    }
    constexpr float kShare = 1.0f / (kParts * kParts);
    n = 0;
    for (int y = 0; y < t.count.y; ++y)
        for (int x = 0; x < t.count.x; ++x, ++n) {
            glm::vec3 keep(0), add(0);
            float cover = 0;
            for (int j = kParts * y; j < kParts * (y + 1); ++j)
                for (int i = kParts * x; i < kParts * (x + 1); ++i) {
                    const glm::vec4& outline =
                        t.outlines[static_cast<std::size_t>(j) * across + static_cast<std::size_t>(i)];
                    const SliceLooks::Set& set = looks_.sets[ownerAt(i, j)];
                    const float drawn = std::min(outline.a, 1.0f), left = 1 - drawn;
                    keep += left * set.keep;
                    add += left * set.add;
                    cover += left * set.cover + drawn;
                    if (drawn > 0)
                        add += drawn / outline.a * glm::vec3(outline);
                }
            t.over[n] = {kShare * keep, kShare * add, kShare * cover};
        }
}

SliceLabels::Drawn SliceLabels::layOver(std::span<glm::vec4> pixels, const SurfacePlaces& places,
                                        double outlineScale, const std::vector<float>* shares) {
    const glm::ivec2 size = places.size, tiles = (size + (kTile - 1)) / kTile;
    TESSERA_CHECK(pixels.size() == static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
    TESSERA_CHECK(!shares || shares->size() == pixels.size());
    Drawn drawn;
    drawn.level = levelOf(places);
    std::vector<std::uint8_t> met(looks_.labels.size());
    std::mutex meeting;
    parallelFor(
        static_cast<std::size_t>(tiles.x) * static_cast<std::size_t>(tiles.y), threads_, [&](std::size_t n) {
            Tile tile{places,
                      SetReader(*cache_, voxels_->info(), drawn.level, labels_.borders, looks_.ofSet)};
            tile.met.resize(looks_.labels.size());
            tile.outlineScale = outlineScale;
            tile.first = kTile * glm::ivec2(static_cast<int>(n) % tiles.x, static_cast<int>(n) / tiles.x);
            tile.count = glm::min(glm::ivec2(kTile), size - tile.first);
            if (!showsAny(pixels, size, tile.first, tile.count))
                return;
            draw(tile);
            for (std::size_t i = 0; i < tile.over.size(); ++i) {
                const glm::ivec2 at = tile.first + glm::ivec2(static_cast<int>(i) % tile.count.x,
                                                              static_cast<int>(i) / tile.count.x);
                const std::size_t to = static_cast<std::size_t>(at.y) * static_cast<std::size_t>(size.x) +
                                       static_cast<std::size_t>(at.x);
                pixels[to] = shares ? tile.over[i](pixels[to], (*shares)[to]) : tile.over[i](pixels[to]);
            }
            const std::lock_guard lock(meeting);
            for (std::size_t label = 0; label < met.size(); ++label)
                met[label] |= tile.met[label];
        });
    for (std::size_t label = 0; label < met.size(); ++label)
        if (met[label])
            drawn.values.push_back(table_.labels[label].value);
    std::sort(drawn.values.begin(), drawn.values.end());
    return drawn;
}

LabelsOver SliceLabels::overPixel(const glm::ivec2& pixel, const SurfacePlaces& places) {
    Tile tile{places, SetReader(*cache_, voxels_->info(), levelOf(places), labels_.borders, looks_.ofSet)};
    tile.met.resize(looks_.labels.size());
    tile.first = pixel;
    tile.count = {1, 1};
    draw(tile);
    return tile.over[0];
}

} // namespace tessera
