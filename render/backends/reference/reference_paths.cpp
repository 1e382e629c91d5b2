// render/backends/reference/reference_paths.cpp: see reference_paths.h.
#include "render/backends/reference/reference_paths.h"

#include "render/backends/reference/cell_gradients.h"

namespace tessera {
namespace {

glm::ivec3 cellOf(const glm::dvec3& p) {
    return glm::ivec3(glm::floor(p - 0.5));
}

/// As the contract's functions ask for it.
struct LabelsAt {
    LabelField& field;
    leaf::LabelShares<double> labels(const glm::dvec3& p) { return field.shares(p); }
};

std::optional<LabelField> labelsOf(const ReferenceInput& input, const Selection& finest) {
    if (!input.labels)
        return {};
    return std::optional<LabelField>(std::in_place, *input.labels, finest, nullptr, input.info->extentVoxels);
}

} // namespace

ReferencePaths::ReferencePaths(const IntegralInput& of, LatticeReader& samples)
    : scene_(*of.given.paths), function_(of.function), optics_(of.optics), samples_(samples),
      finest_(finestOf(*of.given.info)), labels_(labelsOf(of.given, finest_)),
      rays_(*of.given.info, optics_, of.paths->obstacles, of.paths->sources, of.paths->emptyCells, samples,
            labels_ ? &*labels_ : nullptr, of.given.panels),
      tracer_(scene_, noField_, work_) {}

glm::dvec3 ReferencePaths::gradientAt(const glm::dvec3& p, Gradient by) {
    const glm::ivec3 low = cellOf(p);
    return gradientInCell(Neighbourhood(samples_, low, by), low, by, p);
}

PathTissue ReferencePaths::tissueAt(const glm::dvec3& p) {
    const double stored = Cell(samples_, cellOf(p)).at(p);
    const FunctionPiece piece = function_.pieceAround(stored);
    const double value = piece.value(stored);
    glm::dvec3 colour(piece.colourAt(value, 0), piece.colourAt(value, 1), piece.colourAt(value, 2));
    if (labels_ && optics_.labels.colour >= 0) {
        double extinction = piece.extinctionAt(value);
        if (optics_.grades())
            extinction *= gradientFactor<double>(optics_, gradientAt(p, optics_.gradient));
        LabelsAt labels{*labels_};
        LabelledSample<double> labelled(optics_, labels, p);
        labelled.take(extinction);
        colour = labelled.colour(colour);
    }
    return {glm::vec3(colour), optics_.lighting.emits ? glm::vec3(function_.emission(stored)) : glm::vec3(0),
            tissueNumber(scene_, static_cast<float>(stored))};
}

std::span<const RayPart> ReferencePaths::partsOf(const Way& way) {
    parts_.assign(1, {0, double{way.mm}});
    if (scene_.cuts)
        keptParts(*scene_.cuts, way, parts_);
    return parts_;
}

double ReferencePaths::left(const Way& way) {
    double left = 1;
    const glm::dvec3 from(way.from), perMm(way.perMm);
    for (const RayPart& part : partsOf(way))
        if (left > 0)
            left *= rays_.reach(from + part.from * perMm, perMm, part.to - part.from, LightRays::kDark).left;
    return left;
}

double ReferencePaths::toCollision(const Way& way, double share) {
    const glm::dvec3 from(way.from), perMm(way.perMm);
    for (const RayPart& part : partsOf(way)) {
        const LightRays::Reached reached =
            rays_.reach(from + part.from * perMm, perMm, part.to - part.from, share);
        if (reached.mm >= 0)
            return part.from + reached.mm;
        share /= reached.left;
    }
    return -1;
}

glm::dvec4 ReferencePaths::operator()(const ReferenceRay& ray, std::span<const RayPart> parts, double alpha,
                                      const PathStart& start) {
    TracedPath path(scene_, start.place, start.number);
    double share = 1 - double{path.numbers.pair(0).x} * alpha;
    std::optional<double> at; // mm along the ray
    for (const RayPart& part : parts) {
        const LightRays::Reached reached =
            rays_.reach(ray.base + part.from * ray.direction, ray.direction, part.to - part.from, share);
        if (reached.mm >= 0) {
            at = part.from + reached.mm;
            break;
        }
        share /= reached.left;
    }
    if (!at)
        return {0, 0, 0, alpha}; // by rounding
    const glm::dvec3 seen = ray.base + *at * ray.direction;
    tracer_.start(path, glm::vec3(seen), tissueAt(seen), glm::vec3(ray.direction));
    tracer_.begin(path);
    Way way;
    do {
        const glm::vec3 gradient = tracer_.takesGradients()
                                       ? glm::vec3(gradientAt(glm::dvec3(path.p), scene_.normals))
                                       : glm::vec3(0);
        const bool isLit = tracer_.aim(path, gradient, way), squared = isSquared(scene_, path);
        if (isLit)
            Tracer::shineBy(path, squared ? path.passed : static_cast<float>(left(way)));
        if (!tracer_.turn(path, way))
            break;
        if (isLast(scene_, path)) {
            tracer_.leave(path, squared ? path.passed : static_cast<float>(left(way)));
            break;
        }
        // 1 - u, u from 0 to below 1, is the share of light that a free path leaves.
        const double collision = toCollision(way, 1 - double{path.numbers.next()});
        if (!tracer_.reach(path, way, static_cast<float>(collision)))
            break;
        if (asksWhatPassed(scene_, path))
            path.passed = static_cast<float>(left({way.from, way.perMm, static_cast<float>(collision)}));
    } while (tracer_.settle(path, tissueAt(glm::dvec3(path.p))));
    return {alpha * glm::dvec3(path.sum), alpha};
}

} // namespace tessera
