// viewer/cli/input/environment_input.cpp: see environment_input.h.
#include "viewer/cli/input/environment_input.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "render/transport/environment_map.h"
#if TESSERA_WITH_ENVIRONMENTS
#include "core/image/environment_file.h"
#endif

namespace tessera {

Charge readEnvironmentOf(Scene& scene, MemoryBudget& ram, std::vector<std::string>& notes) {
    if (!scene.lighting.environment || scene.lighting.environment->file.path.empty())
        return {};
    EnvironmentFile& file = scene.lighting.environment->file;
#if TESSERA_WITH_ENVIRONMENTS
    Charge charge = ram.charge(EnvironmentMap::bytes(EnvironmentPixels::kKept), "an environment's light");
    if (!file.map) {
        EnvironmentPixels pixels = readEnvironment(file.path, ram);
        file.map = std::make_shared<const EnvironmentMap>(pixels.size, std::move(pixels.radiance));
        notes.insert(notes.end(), pixels.notes.begin(), pixels.notes.end());
    }
    file.path = std::filesystem::absolute(file.path); // scenes are saved elsewhere
    return charge;
#else
    (void)ram;
    (void)notes;
    throw InputError(printable(file.path.string()) +
                     ": this program was built without files of environments");
#endif
}

} // namespace tessera
