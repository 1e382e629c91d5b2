// A small volume in memory, whose values are extinctions per voxel, for paths: its field, its bounds.
#pragma once

#include "core/base/budget.h"
#include "render/contract/sampler.h"
#include "render/transport/path_scene.h"

#include <functional>
#include <memory>
#include <vector>

namespace tessera {

class PathVolume {
  public:
    /// @param value  of a voxel; extinction per mm is the value, colour `albedo`
    /// @param axes  of voxels, mm
    PathVolume(const glm::ivec3& extent, const std::function<float(const glm::ivec3&)>& value, double most,
               const glm::dvec3& albedo = glm::dvec3(1), const glm::dmat3& axes = glm::dmat3(1))
        : extent_(extent) {
        info_.extentVoxels = extent;
        info_.patientFromVoxel = glm::dmat4(axes);
        glm::ivec3 at(0);
        for (at.z = 0; at.z < extent.z; ++at.z)
            for (at.y = 0; at.y < extent.y; ++at.y)
                for (at.x = 0; at.x < extent.x; ++at.x)
                    values_.push_back(value(at));
        fillStatistics();
        selection_.bricks = brickGrid(extent);
        selection_.levels.assign(cellCount(selection_.bricks), 0);
        selection_.means.assign(selection_.levels.size(), 0);
        selection_.counts[0] = selection_.levels.size();
        table_ = makeTable(TransferFunction::fromExtinction({{0, 0}, {most / 512, most / 512}, {most, most}},
                                                            {{0, albedo}}));
        optics_ = makeOptics(table_, info_, Shading{}, 0);
        setShading(optics_, Shading{});
        const OccupancyInput input{statistics_, table_, info_, selection_};
        occupancy_ = std::make_unique<Occupancy>(input, MapScale::cells, ram_, 1);
        bounds_ = ExtinctionBounds(input, optics_, static_cast<float>(4 * most), ram_, 1);
    }

    // As samples and as a field.
    const glm::ivec3& extent() const { return extent_; }
    float at(const glm::ivec3& i) const { return values_[linearIndex(i, extent_)]; }
    float value(const glm::vec3& p) const { return fieldValue(*this, p, 1.0f); }
    glm::vec3 gradient(const glm::vec3&) const { return glm::vec3(0); }
    glm::vec3 gradient(const glm::vec3&, Gradient) const { return glm::vec3(0); }
    float pitch(const glm::vec3&) const { return 1; }
    glm::vec3 mediumGradient(const glm::vec3&) const { return glm::vec3(0); }
    leaf::LabelShares<float> labels(const glm::vec3&) const { return {}; }

    PathScene scene(const Transport& transport, const std::vector<Light>& lights,
                    const std::optional<Environment>& environment = {}, const Camera& camera = {},
                    const std::vector<Tissue>& tissues = {}) const {
        Lighting lighting;
        lighting.lights = lights;
        lighting.transport = transport;
        lighting.environment = environment;
        PathScene scene = pathScene(lighting, camera, info_, optics_, bounds_, occupancy_.get(), 1, tissues);
        if (lights.empty())
            scene.lights.clear(); // the sky alone
        return scene;
    }
    const ExtinctionBounds& bounds() const { return bounds_; }
    const Occupancy& occupancy() const { return *occupancy_; }
    const Optics& optics() const { return optics_; }
    float extinction(const glm::vec3& p) const { return lookUp(optics_, value(p)).a; }

  private:
    void fillStatistics() {
        statistics_.cells = cellGrid(extent_);
        statistics_.bricks = brickGrid(extent_);
        const auto ranges = [&](const glm::ivec3& grid, int edge, int around, std::vector<float>& low,
                                std::vector<float>& high) {
            glm::ivec3 cell(0);
            for (cell.z = 0; cell.z < grid.z; ++cell.z)
                for (cell.y = 0; cell.y < grid.y; ++cell.y)
                    for (cell.x = 0; cell.x < grid.x; ++cell.x) {
                        const glm::ivec3 from = glm::max(edge * cell - around, glm::ivec3(0)),
                                         to = glm::min(edge * (cell + 1) + around, extent_);
                        float least = at(from), most = least;
                        glm::ivec3 i(0);
                        for (i.z = from.z; i.z < to.z; ++i.z)
                            for (i.y = from.y; i.y < to.y; ++i.y)
                                for (i.x = from.x; i.x < to.x; ++i.x) {
                                    least = std::min(least, at(i));
                                    most = std::max(most, at(i));
                                }
                        low.push_back(least);
                        high.push_back(most);
                    }
        };
        ranges(statistics_.cells, kCellExtent, 1, statistics_.cellMin, statistics_.cellMax);
        ranges(statistics_.bricks, kBrickExtent, 1, statistics_.brickMin, statistics_.brickMax);
        ranges(statistics_.bricks, kBrickExtent, 2, statistics_.wideMin, statistics_.wideMax);
        statistics_.brickMean.assign(statistics_.brickMin.size(), 0);
    }

    glm::ivec3 extent_;
    VolumeInfo info_;
    std::vector<float> values_;
    Statistics statistics_;
    Selection selection_;
    TransferTable table_;
    Optics optics_;
    MemoryBudget ram_{"RAM", "--ram", std::size_t{1} << 30};
    std::unique_ptr<Occupancy> occupancy_;
    ExtinctionBounds bounds_;
};

} // namespace tessera
