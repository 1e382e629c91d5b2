// tests/bench/papers/systems.cpp: the table of what four papers describe, and where it is.
#include "tests/bench/papers/papers.h"

namespace tessera::bench {

const std::vector<PaperSystem>& paperSystems() {
    static const std::vector<PaperSystem> systems = {
        {"C1", "trilinear reconstruction of cell-centred samples", "render/contract/sampler.h", "works", ""},
        {"C2", "emission and absorption", "render/contract/integrators.h", "works", "accuracy.md"},
        {"C3", "emission alone, absorption alone", "render/exposure/exposed_caster.h", "works", ""},
        {"C4", "front-to-back compositing, early termination", "render/contract/integrators.h", "works",
         "accuracy.md"},
        {"C5", "rays set up by rasterised faces of the box", "render/contract/ray.h", "better: closed form",
         "papers.md"},
        {"C6", "image-order skipping by ranges of cells", "render/empty_space/distance_map.h", "works",
         "level-of-detail.md"},
        {"C7", "object-order skipping: start and length images", "tests/bench/papers/object_order.cpp",
         "measured, not used", "papers.md"},
        {"C8", "near-plane rules of the start image", "render/contract/ray.h",
         "better: rays begin at the eye", "papers.md"},
        {"C9", "culling by sums of opacity", "core/scene/transfer_function.h", "works", "level-of-detail.md"},
        {"C10", "opaque geometry in the volume", "render/geometry/mesh_rays.h", "works", ""},
        {"C11", "isosurfaces, refined, several at once", "render/contract/cell_roots.h", "works",
         "performance.md"},
        {"C12", "brick cache with reference texture, least recently used",
         "render/residency/brick_residency.h", "works", "level-of-detail.md"},
        {"C13", "eight bricks of level l+1 in the room of one", "render/residency/pages.h", "works",
         "level-of-detail.md"},
        {"C14", "duplicated borders", "render/backends/native/host_plane.h",
         "works at level 0; mixed levels counted, not built", "performance-trials.md"},
        {"C15", "address translation by scale and offset", "render/residency/brick_residency.h",
         "otherwise: entries of an index", ""},
        {"C16", "presence bits", "tests/bench/papers/presence.cpp", "measured, no use", "papers.md"},
        {"C17", "hierarchical multiresolution", "tests/bench/lod/hierarchy.h", "for comparison",
         "level-of-detail.md"},
        {"C18", "levels by view and L*u*v* error under the function", "bricking/levels/level_chooser.h",
         "works", "level-of-detail.md"},
        {"C19", "levels by data error alone", "bricking/levels/level_error.h",
         "better: error under the function", "level-of-detail.md"},
        {"C20", "discrete cosine transform, lossy codes", "tests/bench/papers/dct_blocks.h", "measured",
         "papers.md"},
        {"C21", "out of core, prefetch", "bricking/cache/brick_cache.h", "works, by address too", ""},
        {"C22", "flat blocking, interblock interpolation, four edge functions", "render/contract/level_map.h",
         "works", "level-of-detail.md"},
        {"C23", "adaptive object-space sampling", "render/contract/strides.h", "works", "level-of-detail.md"},
        {"C24", "Phong and Blinn-Phong, lights, attenuation", "render/contract/leaf_light_model.h", "works",
         "light.md"},
        {"C25", "forward, central, Sobel gradients", "render/contract/leaf_field.h", "works", ""},
        {"C26", "gradient of the classified field", "render/contract/leaf_field.h",
         "measured, not used: more rings than by values", "performance-trials.md"},
        {"C27", "gradient filtering", "render/contract/leaf_field.h", "works", ""},
        {"C28", "mirror reflection into an environment", "render/light/reflections.h", "works", "light.md"},
        {"C29", "rays of order 0 to 3", "render/light/reflections.h", "works, 0 to 8", "light.md"},
        {"C30", "refraction, total reflection", "render/light/reflections.h", "works", "light.md"},
        {"C31", "specularity by value or gradient", "core/scene/reflection.h",
         "works: by the gradient, and by Fresnel", "light.md"},
        {"C32", "shadow rays", "render/backends/reference/light_rays.h", "works: reference, paths",
         "light.md"},
        {"C33", "shadow map of first hits", "render/light/first_hit_map.h", "works", "light.md"},
        {"C34", "percentage closer filtering", "render/light/first_hit_map.h", "works", "light.md"},
        {"C35", "deep shadow maps", "render/light/deep_shadow_map.h", "works", "light.md"},
        {"C36", "occlusion of isosurfaces", "render/light/surface_light.h", "works", "light.md"},
        {"C37", "local ambient occlusion", "render/light/occlusion.h", "works", "light.md"},
        {"C38", "weights of directions", "core/scene/lighting.h", "works", "light.md"},
        {"C39", "emissive tissue", "render/light/occlusion.h", "works", "light.md"},
        {"C40", "occlusion at mixed resolution", "render/light/occlusion.h", "works", "light.md"},
        {"C41", "piecewise propagation on a sparse grid", "render/light/deep_shadow_map.h",
         "counted, not built: deep maps", "light.md"},
        {"C42", "in-scattering", "render/light/scatter_light.h", "works", "light.md"},
        {"C43", "local histograms", "bricking/statistics/local_histograms.h", "works", "light.md"},
        {"C44", "packed and quantised histograms", "bricking/statistics/vector_quantiser.h", "works",
         "light.md"},
        {"C45", "environment colour, bleeding, glow", "render/light/histogram_light.h", "works", "light.md"},
        {"C46", "single scattering", "render/transport/path.h", "works", "paths.md"},
        {"C47", "indirect light, translucency", "render/transport/path.h", "works", "paths.md"},
        {"C48", "Henyey-Greenstein, Schlick, Rayleigh", "render/transport/phase.h", "works", "paths.md"},
        {"C49", "surface where the gradient is steep, phase elsewhere", "render/transport/surface_response.h",
         "works", "paths.md"},
        {"C50", "practical phase function", "render/transport/surface_response.h", "works", "paths.md"},
        {"C51", "Monte Carlo in place of aliasing", "render/pixels/area_picture.h", "works",
         "measured-errors.md"},
        {"C52", "importance sampling", "render/transport/surface_response.h", "works", "paths.md"},
        {"C53", "rejection sampling, focusing", "tests/render/transport/focusing_test.cpp",
         "tested, not used: exact lobes", "paths.md"},
        {"C54", "area-preserving sampling of lobes", "render/transport/surface_response.h", "works",
         "paths.md"},
        {"C55", "filtered environment maps", "render/transport/environment_map.h", "works", "paths.md"},
        {"C56", "Monte Carlo ray casting", "render/transport/tracking.h", "works", "paths.md"},
        {"C57", "first-hit pass", "render/picture/deferred_light.h", "works", ""},
        {"C58", "deferred shading", "render/picture/deferred_light.h", "works", "light.md"},
        {"C59", "scattering pass between isosurfaces", "render/transport/path.h", "works", "paths.md"},
        {"C60", "few scatterings, squared attenuation", "render/transport/path.h", "works, as previews",
         "paths.md"},
        {"C61", "shadow volume, slice by slice", "render/light/light_sweep.h", "works", "light.md"},
        {"C62", "scattering light map", "render/light/light_map.h", "works", "light.md"},
        {"C63", "deep map beside a coarse light map", "render/light/map_light.h", "works", "light.md"},
        {"H1", "M hulls of N samples", "render/contract/ray_cuts.h", "works", "papers.md"},
        {"H2", "valid sampling path", "render/contract/ray_cuts.h", "works", "papers.md"},
        {"H3", "opacity correction", "render/contract/integrators.h", "works", ""},
        {"H4", "occlusion interpolated along the ray", "render/light/light_plane.h",
         "otherwise: light per voxel is interpolated", "papers.md"},
        {"H5", "variance shadow maps", "render/light/first_hit_map.h", "works", "light.md"},
        {"H6", "local coordinates map, 2 + 2M passes", "render/contract/ray_cuts.h",
         "otherwise: one march has all hulls", "papers.md"},
        {"H7", "slices, for comparison", "tests/bench/papers/hulls.cpp", "for comparison", "papers.md"},
        {"H8", "M and N by themselves", "render/plan/step_search.h", "works", "papers.md"},
        {"W1", "filter of volume samples on the picture", "render/backends", "not yet", "papers.md"},
        {"W2", "three filters by depth", "render/backends", "not yet", "papers.md"},
        {"W3", "three orders of slices, sheet buffers", "render/backends", "not yet", "papers.md"},
        {"W4", "the filter by patch", "render/backends", "not yet", "papers.md"},
        {"W5", "packed vertices", "render/backends", "not yet", "papers.md"},
        {"W6", "lists by value for edits", "render/backends", "not yet", "papers.md"},
        {"W7", "shading once a splat", "render/backends", "not yet", "papers.md"},
        {"W8", "tables 1 to 5, figures 8 and 9", "tests/bench/papers", "not yet", "papers.md"},
        {"V1", "occlusion over the hemisphere by rays", "render/light/surface_light.h", "works", "light.md"},
        {"V2", "a volume for each object, products", "render/geometry", "not yet", "light.md"},
        {"V3", "voxels of meshes, three ways", "render/geometry", "not yet", "light.md"},
        {"V4", "a scene's voxels at once, as words of bits", "render/geometry", "not yet", "light.md"},
        {"V5", "guard distance", "render/light", "not yet", "light.md"},
        {"V6", "isosurfaces of a field", "render/contract/cell_roots.h", "works", ""},
        {"V7", "falling samples rejected, attenuation", "render/light/occlusion.h", "works", "light.md"},
        {"V8", "positional occlusion", "render/light/occlusion.h", "works", "light.md"},
        {"V9", "transparent meshes as alpha volumes", "render/geometry", "not yet", "light.md"},
        {"V10", "joint bilateral filter, fewer pixels", "render/light/surface_light.h", "not yet",
         "light.md"},
        {"V11", "resolution, threshold, scaling", "tests/bench/papers", "not yet", "light.md"},
    };
    return systems;
}

Report systemsReport(const Workbench&) {
    Report report;
    report.name = "systems";
    report.title = "Every system, and where it is";
    report.text = {"C1 to C63: Advanced volume ray casting, course notes (parts I to IV). H1 to H8: Imagire "
                   "et al., sampling hulls (2007). W1 to W8: "
                   "EWA volume splatting. V1 to V11: volume-based ambient occlusion of meshes and volumes. "
                   "*Measured* names the page with figures."};
    Table table{"systems", "", {"", "system", "where", "what it is here", "measured"}, {}, true};
    for (const PaperSystem& s : paperSystems()) {
        const std::string page = s.measured;
        table.rows.push_back({std::string(s.id), std::string(s.what), "`" + std::string(s.where) + "`",
                              std::string(s.status),
                              page.empty() || page == "papers.md" ? (page.empty() ? "" : "below")
                                                                  : "[" + page + "](" + page + ")"});
    }
    report.tables = {std::move(table)};
    return report;
}

} // namespace tessera::bench
