// viewer/session/volume_offers.h: the volumes of a folder that holds more than one, as a list to choose from,
// with a small picture of each.
#pragma once

#include "core/base/budget.h"
#include "core/base/interrupt.h" // Cancellation
#include "viewer/cli/input/volume_input.h"
#include "viewer/session/viewing.h"

#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <string>

namespace tessera {

/// The volumes at a path, in the order of the table of series, those that cannot be opened with the reason.
/// Null where there is nothing to choose: fewer than two, and no phases, uneven slices or files that could be
/// left out.
/// @param input  what else is asked for
/// Throws InputError where nothing is there.
std::shared_ptr<const VolumeOffers> volumeOffers(const std::filesystem::path& path,
                                                 const InputOptions& input);

/// Whether a message is about a choice that options could make: one that a list can offer instead.
bool asksForChoice(const std::string& message);

/// What opens an offer.
InputOptions optionsFor(const VolumePick& pick, const InputOptions& input);

/// Reads the middle slice of each offer, one after the other, on a thread of its own.
class OfferThumbnails {
  public:
    /// @param ram  a slice at a time is charged to it; what does not fit has no thumbnail. Outlives this.
    /// @param made  is called from the thread with the number of an offer and its thumbnail
    OfferThumbnails(std::shared_ptr<const VolumeOffers> offers, const InputOptions& input,
                    std::shared_ptr<MemoryBudget> ram,
                    std::function<void(std::size_t, std::shared_ptr<const Thumbnail>)> made);
    /// Calls it off, and waits.
    ~OfferThumbnails();

  private:
    Cancellation::Flag calledOff_{false};
    std::future<void> done_;
};

/// The middle slice of a source, its grey from the darkest to the brightest hundredth, at most `edge` pixels
/// along each side. Null where a slice does not fit into ram. Throws what reading throws; Cancelled.
std::shared_ptr<const Thumbnail> middleSlice(SlabSource& source, MemoryBudget& ram, int edge);

} // namespace tessera
