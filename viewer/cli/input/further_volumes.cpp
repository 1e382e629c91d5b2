// viewer/cli/input/further_volumes.cpp: see further_volumes.h.
#include "viewer/cli/input/further_volumes.h"

#include "viewer/cli/input/label_input.h"
#include "viewer/cli/input/named_scene.h"
#include "viewer/cli/input/volume_input.h"

#include <cstddef>
#include <filesystem>

namespace tessera {

std::vector<std::unique_ptr<StoreReader>> openFurtherVolumes(Scene& scene, MemoryBudget& ram,
                                                             const CommonOptions& common) {
    std::vector<std::unique_ptr<StoreReader>> stores;
    for (std::size_t n = 1; n < scene.volumes.size(); ++n) {
        SceneVolume& volume = scene.volumes[n];
        stores.push_back(std::make_unique<StoreReader>(storeFor(volume, InputOptions{}, ram, common), ram,
                                                       volume.transform));
        volume.path = std::filesystem::absolute(volume.path).lexically_normal(); // saved, it opens again
        nameFunction(volume, stores.back()->info());
        importLabelsFor(stores.back()->info(), volume.labels, ram, common);
    }
    return stores;
}

std::vector<const StoreReader*> storesOf(const StoreReader& first,
                                         const std::vector<std::unique_ptr<StoreReader>>& further) {
    std::vector<const StoreReader*> stores = {&first};
    for (const auto& reader : further)
        stores.push_back(reader.get());
    return stores;
}

} // namespace tessera
