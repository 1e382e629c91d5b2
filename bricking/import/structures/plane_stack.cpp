// bricking/import/structures/plane_stack.cpp: see plane_stack.h.
#include "bricking/import/structures/plane_stack.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkMarchingCubesTriangleCases.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

namespace tessera {
namespace {

constexpr int kMargin = 2;             // grid points around the rings
constexpr int kMostLayersBetween = 16; // of two planes
/// VTK's of a point and of a triangle, besides ours: coordinates, numbers, growth of lists.
constexpr std::size_t kBytesOfPoint = 64, kBytesOfTriangle = 96;

struct SurfaceCount {
    std::size_t points = 0, triangles = 0;
};

/// Of the surface that flying edges make, which uses the cases of marching cubes.
SurfaceCount countOf(const std::vector<float>& values, const glm::ivec3& size) {
    const auto nx = static_cast<std::size_t>(size.x), ny = static_cast<std::size_t>(size.y);
    std::array<std::size_t, 256> trianglesOf{};
    for (std::size_t code = 0; code < trianglesOf.size(); ++code)
        for (const int* edge = vtkMarchingCubesTriangleCases::GetCases()[code].edges; *edge >= 0; edge += 3)
            ++trianglesOf[code];
    const auto isUp = [&](int x, int y, int z) {
        return values[(static_cast<std::size_t>(z) * ny + static_cast<std::size_t>(y)) * nx +
                      static_cast<std::size_t>(x)] >= 0;
    };
    SurfaceCount count;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const bool here = isUp(x, y, z);
                count.points += (x + 1 < size.x && isUp(x + 1, y, z) != here) +
                                (y + 1 < size.y && isUp(x, y + 1, z) != here) +
                                (z + 1 < size.z && isUp(x, y, z + 1) != here);
                if (x + 1 == size.x || y + 1 == size.y || z + 1 == size.z)
                    continue;
                const unsigned code =
                    unsigned{here} | unsigned{isUp(x + 1, y, z)} << 1 | unsigned{isUp(x + 1, y + 1, z)} << 2 |
                    unsigned{isUp(x, y + 1, z)} << 3 | unsigned{isUp(x, y, z + 1)} << 4 |
                    unsigned{isUp(x + 1, y, z + 1)} << 5 | unsigned{isUp(x + 1, y + 1, z + 1)} << 6 |
                    unsigned{isUp(x, y + 1, z + 1)} << 7;
                count.triangles += trianglesOf[code];
            }
    return count;
}

/// Of points, means over their triangles by area.
void addNormals(TriangleMesh& mesh) {
    std::vector<glm::dvec3> sums(mesh.points.size());
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a(mesh.points[t.x]), b(mesh.points[t.y]), c(mesh.points[t.z]);
        const glm::dvec3 flat = glm::cross(b - a, c - a);
        for (int corner = 0; corner < 3; ++corner)
            sums[t[corner]] += flat;
    }
    mesh.normals.reserve(sums.size());
    for (const glm::dvec3& sum : sums) {
        const double length = glm::length(sum);
        mesh.normals.emplace_back(length > 0 ? sum / length : glm::dvec3(0, 0, 1));
    }
}

} // namespace

PlaneStack::PlaneStack(const StructurePlanes& planes, std::size_t first, std::size_t end, double stepMm)
    : planes_(planes) {
    TESSERA_CHECK(first < end && end <= planes.planes.size() && planes.spacingMm > 0 && stepMm > 0);
    glm::dvec2 low(std::numeric_limits<double>::max()), high(-low);
    for (std::size_t i = first; i < end; ++i)
        for (const auto& ring : planes.planes[i].rings)
            for (const glm::dvec2& point : ring) {
                low = glm::min(low, point);
                high = glm::max(high, point);
            }
    grid_.step = stepMm;
    grid_.origin = low - kMargin * stepMm;
    const glm::dvec2 wanted = glm::ceil((high - low) / stepMm) + 2.0 * kMargin + 1.0;
    constexpr double kMostAlong = 1 << 28;
    grid_.nx = static_cast<int>(std::min(wanted.x, kMostAlong));
    grid_.ny = static_cast<int>(std::min(wanted.y, kMostAlong));
    const auto apart = [&](std::size_t i) { return planes.planes[i + 1].at - planes.planes[i].at; };
    const double before = end - first > 1 ? std::min(apart(first), planes.spacingMm) : planes.spacingMm;
    const double behind = end - first > 1 ? std::min(apart(end - 2), planes.spacingMm) : planes.spacingMm;
    const double lowest = planes.planes[first].at - before / 2,
                 highest = planes.planes[end - 1].at + behind / 2;
    layers_.push_back({lowest, first, first, 0, true}); // both at one place: the plane that closes it
    layers_.push_back({lowest, first, first, 0, false});
    for (std::size_t i = first; i < end; ++i) {
        layers_.push_back({planes.planes[i].at, i, i, 0, false});
        if (i + 1 == end)
            break;
        const int between = std::clamp(static_cast<int>(std::ceil(apart(i) / stepMm)), 1, kMostLayersBetween);
        for (int n = 1; n < between; ++n) {
            const double share = static_cast<double>(n) / between;
            layers_.push_back({planes.planes[i].at + share * apart(i), i, i + 1, share, false});
        }
    }
    layers_.push_back({highest, end - 1, end - 1, 0, false});
    layers_.push_back({highest, end - 1, end - 1, 0, true});
}

std::size_t PlaneStack::gridBytes() const {
    constexpr std::size_t kBytesOfRow = 64; // of flying edges
    return points() * (sizeof(float) + 1) +
           static_cast<std::size_t>(grid_.ny) * layers_.size() * kBytesOfRow +
           static_cast<std::size_t>(defaultThreads()) * grid_.scratchBytes();
}

std::vector<float> PlaneStack::distances() const {
    std::vector<float> values(points());
    const std::size_t plane = grid_.points();
    const auto layerOf = [&](std::size_t n) { return std::span(values).subspan(n * plane, plane); };
    std::vector<std::size_t> ofPlanes; // layers that are a plane's own
    for (std::size_t n = 0; n < layers_.size(); ++n)
        if (!layers_[n].isOutside && layers_[n].share == 0 &&
            layers_[n].at == planes_.planes[layers_[n].below].at)
            ofPlanes.push_back(n);
    parallelFor(ofPlanes.size(), 0, [&](std::size_t i) {
        checkInterrupted();
        distancesTo(planes_.planes[layers_[ofPlanes[i]].below], grid_, layerOf(ofPlanes[i]));
    });
    const auto ownOf = [&](std::size_t number) {
        const auto at = std::find_if(ofPlanes.begin(), ofPlanes.end(),
                                     [&](std::size_t n) { return layers_[n].below == number; });
        return layerOf(*at);
    };
    for (std::size_t n = 0; n < layers_.size(); ++n) {
        const Layer& layer = layers_[n];
        const auto to = layerOf(n);
        const auto below = ownOf(layer.below), above = ownOf(layer.above);
        if (layer.isOutside)
            std::fill(to.begin(), to.end(), 1.0F);
        else if (to.data() != below.data())
            for (std::size_t at = 0; at < plane; ++at) {
                const auto share = static_cast<float>(layer.share);
                const float value = below[at] * (1 - share) + above[at] * share;
                to[at] = std::abs(value) < 1e-4F ? std::copysign(1e-4F, value) : value;
            }
    }
    return values;
}

glm::dvec3 PlaneStack::placeOf(const glm::vec3& point) const {
    const auto last = static_cast<double>(layers_.size() - 1);
    const double z = std::clamp(static_cast<double>(point.z), 0.0, last);
    const auto n = std::min(static_cast<std::size_t>(z), layers_.size() - 2);
    const double w = glm::mix(layers_[n].at, layers_[n + 1].at, z - static_cast<double>(n));
    return planes_.patientFromPlane * glm::dvec3(grid_.origin.x + grid_.step * static_cast<double>(point.x),
                                                 grid_.origin.y + grid_.step * static_cast<double>(point.y),
                                                 w);
}

TriangleMesh PlaneStack::contoured(std::vector<float>& values) const {
    vtkNew<vtkFloatArray> array;
    array->SetArray(values.data(), static_cast<vtkIdType>(values.size()), 1); // ours: VTK does not free it
    vtkNew<vtkImageData> image;
    image->SetDimensions(grid_.nx, grid_.ny, static_cast<int>(layers_.size()));
    image->GetPointData()->SetScalars(array);
    vtkNew<vtkFlyingEdges3D> edges;
    edges->SetInputData(image);
    edges->SetValue(0, 0);
    edges->ComputeNormalsOff();
    edges->ComputeGradientsOff();
    edges->ComputeScalarsOff();
    edges->Update();
    vtkPolyData* const found = edges->GetOutput();
    TriangleMesh mesh;
    mesh.points.reserve(static_cast<std::size_t>(found->GetNumberOfPoints()));
    for (vtkIdType i = 0; i < found->GetNumberOfPoints(); ++i) {
        std::array<double, 3> point{};
        found->GetPoint(i, point.data());
        mesh.points.emplace_back(placeOf(glm::vec3(point[0], point[1], point[2])));
    }
    vtkCellArray* const cells = found->GetPolys();
    mesh.triangles.reserve(static_cast<std::size_t>(cells->GetNumberOfCells()));
    vtkNew<vtkIdList> corners;
    for (vtkIdType i = 0; i < cells->GetNumberOfCells(); ++i) {
        cells->GetCellAtId(i, corners);
        TESSERA_CHECK(corners->GetNumberOfIds() == 3);
        mesh.triangles.emplace_back(static_cast<std::uint32_t>(corners->GetId(0)),
                                    static_cast<std::uint32_t>(corners->GetId(1)),
                                    static_cast<std::uint32_t>(corners->GetId(2)));
    }
    return mesh;
}

std::optional<TriangleMesh> PlaneStack::surface(MemoryBudget& ram, const std::string& what,
                                                bool mustFit) const {
    const Charge ofGrid = ram.charge(gridBytes(), what);
    std::vector<float> values = distances();
    const SurfaceCount count = countOf(values, {grid_.nx, grid_.ny, static_cast<int>(layers_.size())});
    const std::size_t bytes = count.points * kBytesOfPoint + count.triangles * kBytesOfTriangle;
    if (!mustFit && bytes > ram.freeBytes())
        return std::nullopt;
    const Charge ofTriangles = ram.charge(bytes, what);
    TriangleMesh mesh = contoured(values);
    TESSERA_CHECK(mesh.points.size() <= count.points && mesh.triangles.size() <= count.triangles);
    addNormals(mesh);
    return mesh;
}

} // namespace tessera
