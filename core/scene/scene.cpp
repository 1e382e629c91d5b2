// core/scene/scene.cpp: see scene.h. Rules across the parts of a scene. Its names are in scene_names.cpp,
// JSON in scene_reader.cpp and scene_writer.cpp.
#include "core/scene/scene.h"

#include "core/base/error.h"

#include <algorithm>

namespace tessera {

double brightest(const Shading& shading, const Lighting& lighting, const std::vector<Material>& materials) {
    if (!shading.on)
        return 1;
    const double light = maxIncidentLight(lighting.lights);
    double most = std::max(1.0, shading.ambient + light * (shading.diffuse + shading.specular));
    for (const Material& m : materials)
        most = std::max(most, m.ambient + light * (m.diffuse + m.specular) +
                                  std::max({m.emission.r, m.emission.g, m.emission.b}));
    return most;
}

Reduction reductionOf(const Scene& scene) {
    switch (scene.mode) {
    case Mode::maximum:
        return Reduction::maximum;
    case Mode::minimum:
        return Reduction::minimum;
    case Mode::average:
        return Reduction::average;
    case Mode::slice:
        return scene.slice.thicknessMm > 0 ? scene.slice.reduction : Reduction::maximum;
    case Mode::composite:
    case Mode::isosurface:
        break;
    }
    return Reduction::composite;
}

Scene asDrawn(const Scene& scene) {
    Scene drawn = scene;
    if (scene.mode == Mode::isosurface) {
        if (std::none_of(scene.surfaces.begin(), scene.surfaces.end(),
                         [](const Isosurface& s) { return s.opacity > 0; }))
            throw InputError("mode isosurface: expected an isosurface that is not wholly transparent "
                             "(--isosurface VALUE), found none");
        return drawn;
    }
    if (reductionOf(scene) == Reduction::composite)
        return drawn;
    drawn.shading.on = false;
    drawn.lighting = {};
    drawn.surfaces.clear();
    drawn.quality.integrator = Integrator::midpoint;
    return drawn;
}

} // namespace tessera
