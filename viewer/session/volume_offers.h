// viewer/session/volume_offers.h: the list of volumes of a folder with more than one, with a small picture of
// each.
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
/// Null if there is nothing to choose: fewer than two, and no phases, uneven slices or files that could be
/// left out.
/// @param input  further options
/// Throws InputError if the path does not exist.
std::shared_ptr<const VolumeOffers> volumeOffers(const std::filesystem::path& path,
                                                 const InputOptions& input);

/// True if a message is about a choice by options, which a list can offer instead.
bool asksForChoice(const std::string& message);

/// The options that open an offer.
InputOptions optionsFor(const VolumePick& pick, const InputOptions& input);

/// Reads the middle slice of each offer, one after the other, on a thread of its own.
class OfferThumbnails {
  public:
    /// @param ram  one slice at a time is charged to it; without room there is no thumbnail. Outlives this.
    /// @param made  called from the thread with the number of an offer and its thumbnail
    OfferThumbnails(std::shared_ptr<const VolumeOffers> offers, const InputOptions& input,
                    std::shared_ptr<MemoryBudget> ram,
                    std::function<void(std::size_t, std::shared_ptr<const Thumbnail>)> made);
    /// Cancels, and waits.
    ~OfferThumbnails();

  private:
    Cancellation::Flag calledOff_{false};
    std::future<void> done_;
};

/// The middle slice of a source, with greys from the 1st to the 99th percentile, at most `edge` pixels along
/// each side. Null if a slice does not fit into ram. Throws Cancelled, and as reading does.
std::shared_ptr<const Thumbnail> middleSlice(SlabSource& source, MemoryBudget& ram, int edge);

} // namespace tessera
