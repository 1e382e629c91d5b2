// viewer/cli/input/further_volumes.cpp: see further_volumes.h.
#include "viewer/cli/input/further_volumes.h"

#include "bricking/store/shard.h" // describe
#include "bricking/store/stand_in_reader.h"
#include "core/base/address.h"
#include "core/base/dicom_uid.h"
#include "core/base/error.h"
#include "core/base/volume.h"
#include "viewer/cli/input/label_input.h"
#include "viewer/cli/input/named_scene.h"
#include "viewer/cli/input/volume_input.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <glm/vector_relational.hpp>
#include <memory>
#include <span>
#include <string>

namespace tessera {

namespace {

/// A refusal says what would draw the picture.
class RefusingReader : public StoreReader {
  public:
    using StoreReader::StoreReader;
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        try {
            StoreReader::readChunk(key, out);
        } catch (const InputError& problem) {
            throw InputError(std::string(problem.what()) +
                             "; --allow-damaged, without --keep-state, draws it from a coarser level");
        }
    }
};

} // namespace

std::unique_ptr<StoreReader> openForPictures(const std::filesystem::path& store, MemoryBudget& ram,
                                             const glm::dmat4& moved, Damage damage) {
    if (damage == Damage::isRefused)
        return std::make_unique<RefusingReader>(store, ram, moved);
    return std::make_unique<StandInReader>(store, ram, moved);
}

std::vector<std::string> damageLines(Stores stores) {
    std::vector<std::string> lines;
    for (std::size_t n = 0; n < stores.size(); ++n)
        if (const auto* const store = dynamic_cast<const StandInReader*>(stores[n]))
            for (const DamagedChunk& chunk : store->damaged())
                lines.push_back("volume " + std::to_string(n + 1) + ": " + describe(chunk.key) +
                                " is damaged and drawn from level " + std::to_string(chunk.drawnFrom));
    return lines;
}

void sayDamage(const Scene& scene, Stores stores, const CommonOptions& common) {
    for (std::size_t n = 0; n < stores.size(); ++n) {
        const auto* const store = dynamic_cast<const StandInReader*>(stores[n]);
        const std::uint64_t count = store ? store->damagedCount() : 0;
        if (count == 0)
            continue;
        const std::string path = scene.volumes[n].path.string();
        common.problem(std::to_string(count) +
                       (count == 1 ? " damaged chunk was drawn from a coarser level: "
                                   : " damaged chunks were drawn from coarser levels; the first: ") +
                       store->damaged().front().why + "; `tessera validate " + path + "` says more");
    }
}

std::vector<std::unique_ptr<StoreReader>> openFurtherVolumes(Scene& scene, MemoryBudget& ram,
                                                             const CommonOptions& common, Damage damage) {
    std::vector<std::unique_ptr<StoreReader>> stores;
    for (std::size_t n = 1; n < scene.volumes.size(); ++n) {
        SceneVolume& volume = scene.volumes[n];
        stores.push_back(
            openForPictures(storeFor(volume, InputOptions{}, ram, common), ram, volume.transform, damage));
        volume.path = keptPlace(volume.path); // saved, it opens again
        nameFunction(scene, n, stores.back()->info());
        importLabelsFor(stores.back()->info(), volume.labels, ram, common);
    }
    return stores;
}

std::string apartText(Stores stores) {
    const auto text = [](const PatientBox& box) {
        const auto along = [](const char* axis, double low, double high) {
            return std::string(axis) + " " + formatNumber(low) + " to " + formatNumber(high);
        };
        return along("x", box.low.x, box.high.x) + ", " + along("y", box.low.y, box.high.y) + ", " +
               along("z", box.low.z, box.high.z) + " mm";
    };
    const PatientBox first = patientBoxOf(stores.front()->info());
    std::string words;
    for (std::size_t n = 1; n < stores.size(); ++n) {
        const PatientBox box = patientBoxOf(stores[n]->info());
        if (glm::any(glm::greaterThan(box.low, first.high)) ||
            glm::any(glm::greaterThan(first.low, box.high)))
            words += (words.empty() ? "volume " : "; volume ") + std::to_string(n + 1) +
                     " lies apart from the first: " + text(box) + ", the first " + text(first);
    }
    return words;
}

namespace {
bool isMoved(const SceneVolume& volume) {
    return volume.transform != glm::dmat4(1);
}
} // namespace

std::string otherFramesText(const Scene& scene, Stores stores) {
    const std::string& first = stores.front()->info().frameOfReference;
    std::string words;
    for (std::size_t n = 1; n < stores.size(); ++n) {
        const std::string& frame = stores[n]->info().frameOfReference;
        if (areFramesApart(first, frame) && !isMoved(scene.volumes.front()) && !isMoved(scene.volumes[n]))
            words += (words.empty() ? "volume " : "; volume ") + std::to_string(n + 1) +
                     " has another frame of reference, " + frame + ", than the first, " + first +
                     ": places may not fit without a registration (volumes[" + std::to_string(n) +
                     "].transform)";
    }
    return words;
}

std::vector<std::string> framesOfPicture(const Scene& scene, Stores stores) {
    std::vector<std::string> frames;
    if (stores.front()->info().frameOfReference.empty() || isMoved(scene.volumes.front()))
        return frames;
    for (std::size_t n = 0; n < std::min(stores.size(), scene.volumes.size()); ++n)
        if (!isMoved(scene.volumes[n]))
            frames.push_back(stores[n]->info().frameOfReference);
    return frames;
}

std::vector<const StoreReader*> storesOf(const StoreReader& first,
                                         const std::vector<std::unique_ptr<StoreReader>>& further) {
    std::vector<const StoreReader*> stores = {&first};
    for (const auto& reader : further)
        stores.push_back(reader.get());
    return stores;
}

} // namespace tessera
