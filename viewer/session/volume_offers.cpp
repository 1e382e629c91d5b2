// viewer/session/volume_offers.cpp: see volume_offers.h.
#include "viewer/session/volume_offers.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/program_folders.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <iterator>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr int kThumbnailEdge = 72; // pixels

std::string sizeText(const VolumeInfo& info) {
    const glm::dvec3 mm = info.spacingMm();
    return formatExtent(info.extentVoxels) + " voxels, " + numberText(mm.x, 3) + " x " + numberText(mm.y, 3) +
           " x " + numberText(mm.z, 3) + " mm";
}

/// Of a series whose slices are uneven, which interpolation opens (bricking/import/series_table.cpp looks for
/// the same words).
bool isUneven(const ListedRow& row) {
    return row.problem.find("--resample-z") != std::string::npos;
}
bool lacksFiles(const ListedRow& row) {
    return row.problem.find("--allow-missing") != std::string::npos;
}

VolumeOffer offerOf(const ListedRow& row, const ListedVolume* volume, const std::filesystem::path& path) {
    VolumeOffer offer;
    offer.path = volume && row.series == 0 ? volume->path : path;
    offer.pick.series = row.series;
    offer.title = row.series > 0 ? "series " + std::to_string(row.series) : row.what;
    if (!row.modality.empty())
        offer.title += ", " + row.modality;
    offer.about = std::to_string(row.slices) + (row.slices == 1 ? " slice" : " slices");
    if (volume)
        offer.about += ", " + sizeText(volume->info);
    // The table lists phases as text; here they are a list of their own.
    const std::string what =
        row.what.substr(0, row.what.find(std::to_string(row.phases.size()) + " phases for"));
    if (row.series > 0 && !what.empty())
        offer.about += "; " + (what.ends_with(", ") ? what.substr(0, what.size() - 2) : what);
    offer.phases = row.phases;
    if (isUneven(row)) {
        offer.pick.resampleZ = true;
        offer.about += "; uneven slices, which are interpolated";
    }
    if (lacksFiles(row)) {
        offer.pick.allowMissing = true;
        offer.about += "; files that cannot be read are left out";
    }
    if (!row.problem.empty() && !isUneven(row) && !lacksFiles(row))
        offer.problem = row.problem;
    return offer;
}

/// Level-0 values of a slice as they are stored, as doubles.
std::vector<double> storedValues(const std::vector<std::byte>& bytes, ValueType type) {
    std::vector<double> values(bytes.size() / bytesPerValue(type));
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = storedValue(type, bytes.data() + i * bytesPerValue(type));
    return values;
}

} // namespace

std::shared_ptr<const VolumeOffers> volumeOffers(const std::filesystem::path& path,
                                                 const InputOptions& input) {
    const InputListing listing = listInput(path, input);
    auto offers = std::make_shared<VolumeOffers>();
    offers->path = path;
    bool asks = false; // of a single one, too
    for (const ListedRow& row : listing.rows) {
        const auto volume =
            std::find_if(listing.volumes.begin(), listing.volumes.end(), [&](const ListedVolume& v) {
                return v.series == row.series && (row.series > 0 || v.label == row.what);
            });
        if (row.slices == 0) // a report
            continue;
        offers->offers.push_back(offerOf(row, volume == listing.volumes.end() ? nullptr : &*volume, path));
        const VolumeOffer& offer = offers->offers.back();
        asks = asks || offer.phases.size() > 1 || offer.pick.resampleZ || offer.pick.allowMissing;
    }
    offers->passedOver = listing.passedOver;
    return offers->offers.size() > 1 || asks ? offers : nullptr;
}

bool asksForChoice(const std::string& message) {
    constexpr const char* kOptions[] = {"--series", "--largest", "--phase", "--resample-z",
                                        "--allow-missing"};
    return std::any_of(std::begin(kOptions), std::end(kOptions),
                       [&](const char* option) { return message.find(option) != std::string::npos; });
}

InputOptions optionsFor(const VolumePick& pick, const InputOptions& input) {
    if (pick == VolumePick{})
        return input;
    InputOptions options = input;
    options.series = pick.series;
    options.largest = false;
    options.phase = pick.phase;
    options.resampleZ = options.resampleZ || pick.resampleZ;
    options.allowMissing = options.allowMissing || pick.allowMissing;
    return options;
}

std::shared_ptr<const Thumbnail> middleSlice(SlabSource& source, MemoryBudget& ram, int edge) {
    const VolumeInfo& info = source.info();
    const glm::ivec3 extent = info.extentVoxels;
    const std::size_t voxels = static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y);
    const auto charge = ram.tryCharge(voxels * (bytesPerValue(info.type) + 2 * sizeof(double)));
    if (!charge)
        return nullptr;
    std::vector<std::byte> slice(voxels * bytesPerValue(info.type));
    for (int z = 0; z <= extent.z / 2; ++z) {
        checkInterrupted();
        source.readSlices(1, slice);
    }
    const std::vector<double> values = storedValues(slice, info.type);
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const double darkest = sorted[sorted.size() / 100],
                 brightest = sorted[sorted.size() - 1 - sorted.size() / 100];
    // A voxel is as wide and as high as it is.
    const glm::dvec3 mm = info.spacingMm();
    const glm::dvec2 sides(extent.x * mm.x, extent.y * mm.y);
    auto thumbnail = std::make_shared<Thumbnail>();
    thumbnail->size =
        glm::max(glm::ivec2(glm::round(sides * (edge / std::max(sides.x, sides.y)))), glm::ivec2(1));
    for (int y = 0; y < thumbnail->size.y; ++y)
        for (int x = 0; x < thumbnail->size.x; ++x) { // the mean of the voxels that a pixel covers
            const auto from = [](int pixel, int pixels, int all) { return pixel * all / pixels; };
            const int x0 = from(x, thumbnail->size.x, extent.x), y0 = from(y, thumbnail->size.y, extent.y);
            const int x1 = std::max(x0 + 1, from(x + 1, thumbnail->size.x, extent.x)),
                      y1 = std::max(y0 + 1, from(y + 1, thumbnail->size.y, extent.y));
            double sum = 0;
            for (int v = y0; v < y1; ++v)
                for (int u = x0; u < x1; ++u)
                    sum += values[static_cast<std::size_t>(v) * static_cast<std::size_t>(extent.x) +
                                  static_cast<std::size_t>(u)];
            const double mean = sum / ((x1 - x0) * (y1 - y0));
            const double grey =
                brightest > darkest ? std::clamp((mean - darkest) / (brightest - darkest), 0.0, 1.0) : 0;
            const auto code = static_cast<std::uint32_t>(std::lround(255 * grey));
            thumbnail->display.push_back(code | code << 8 | code << 16 | 0xFF000000u);
        }
    return thumbnail;
}

OfferThumbnails::OfferThumbnails(std::shared_ptr<const VolumeOffers> offers, const InputOptions& input,
                                 std::shared_ptr<MemoryBudget> ram,
                                 std::function<void(std::size_t, std::shared_ptr<const Thumbnail>)> made)
    : done_(std::async(std::launch::async, [this, offers = std::move(offers), input, ram = std::move(ram),
                                            made = std::move(made)] {
          const Cancellation asks(&calledOff_);
          for (std::size_t n = 0; n < offers->offers.size(); ++n)
              try {
                  const VolumeOffer& offer = offers->offers[n];
                  VolumePick pick = offer.pick;
                  pick.phase = offer.phases.size() > 1 ? 1 : 0;
                  const ScratchFolder scratch;
                  CommonOptions quiet;
                  quiet.quiet = true;
                  const auto source = openInput(offer.path, optionsFor(pick, input), scratch.path(), quiet);
                  if (auto thumbnail = middleSlice(*source, *ram, kThumbnailEdge))
                      made(n, std::move(thumbnail));
              } catch (const Cancelled&) {
                  return;
              } catch (const Interrupted&) {
                  return;
              } catch (const std::exception&) { // it has none
              }
      })) {}

OfferThumbnails::~OfferThumbnails() {
    calledOff_ = true;
    if (done_.valid())
        done_.wait();
}

} // namespace tessera
