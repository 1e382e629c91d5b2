// tests/bench/tessera_peer.cpp: see tessera_peer.h.
#include "tests/bench/tessera_peer.h"

#include "core/base/error.h"
#include "render/backends/gpu/features.h"
#include "render/backends/gpu/march.h"

#include <cmath>
#include <glm/matrix.hpp>
#include <sstream>

namespace tessera::bench {
namespace {

std::vector<std::string> splitAtCommas(const std::string& text) {
    std::vector<std::string> out;
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, ',');)
        out.push_back(part);
    return out;
}

} // namespace

std::string Variant::name() const {
    return "tessera " + integratorNames()[static_cast<std::size_t>(integrator)] +
           (fetch == Fetch::exact ? " exact" : "");
}

std::vector<Variant> parseVariants(const std::string& integrators, const std::string& fetches) {
    std::vector<Variant> out;
    for (const std::string& fetch : splitAtCommas(fetches))
        for (const std::string& integrator : splitAtCommas(integrators)) {
            out.push_back(
                {parseName<Integrator>(integrator, "--integrators"), parseName<Fetch>(fetch, "--fetch")});
            if (out.back().integrator == Integrator::automatic)
                throw InputError("--integrators: expected the names of integrators, found " + integrator);
        }
    return out;
}

TesseraScene::TesseraScene(const Scene& scene, const StoreReader& store, const std::string& device,
                           Budgets& budgets)
    : scene_(scene), budgets_(budgets), context_(GlDeviceChoice{device}),
      onDevice_(scene, store, context_, budgets) {}

Optics TesseraScene::optics(Integrator integrator, double stepVoxels) const {
    const FramePlan& p = prepared();
    Optics optics = makeOptics(p.layer().table, p.info(), scene_.shading,
                               scene_.quality.terminationTransmittance, integrator);
    const double voxelMm = std::cbrt(std::abs(glm::determinant(glm::dmat3(p.info().patientFromVoxel))));
    preparePreintegration2d(optics, stepVoxels * voxelMm, 0, 1);
    return optics;
}

double TesseraScene::draw(const Optics& optics, double stepVoxels, Fetch fetch, bool counting, Image& picture,
                          Work& work) {
    const FramePlan& p = prepared();
    std::uint32_t features = onDevice_.features(fetch) & ~kIntegratorFeatures;
    features |= integratorFeatures(optics.integrator) | (counting ? kFeatureCounting : 0u);
    const Occupancy* occupancy = (features & kFeatureSkipping) ? &p.layer().occupancy : nullptr;
    Strides strides = p.strides();
    strides.segmentVoxels = stepVoxels;
    March march(features, rayFrame(p.view.camera, p.info(), scene_.imageSize, stepVoxels), p.info(), strides,
                optics, occupancy, budgets_.gpu);
    work = {};
    march.run(onDevice_.engine().field(), Slicing{}, work);
    const auto reading = Clock::now();
    picture = march.image();
    return work.marchMs + msSince(reading);
}

} // namespace tessera::bench
