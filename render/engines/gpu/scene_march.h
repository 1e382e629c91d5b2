// render/engines/gpu/scene_march.h: the march over a prepared scene with its maps of empty space, made finer
// on the device where that pays (fine_mask.h).
#pragma once

#include "render/engines/gpu/fine_mask.h"
#include "render/engines/gpu/march.h"
#include "render/plan/prepare.h"

#include <cstdint>
#include <optional>

namespace tessera {

/// What a scene needs of a march over bricks that are all there, in bits of features.h.
std::uint32_t marchFeatures(const PreparedScene& scene, bool counting);

/// What a march reads the bricks of a prepared scene and their levels from; of its selection as it is now.
struct SceneField {
    SceneField(const PreparedScene& scene, const Atlas& atlas, Ledger& gpu);
    SceneField(const SceneField&) = delete; // source points into it
    SceneField& operator=(const SceneField&) = delete;
    std::optional<LevelTextures> textures; // of mixed levels
    FieldSource source;
};

class SceneMarch {
  public:
    /// @param features  marchFeatures(), with passes where bricks come in several
    SceneMarch(std::uint32_t features, const PreparedScene& scene, Ledger& gpu);

    /// Makes the maps finer where that pays and gpu has room; reads every brick, so all must be there. Does
    /// nothing where bricks come in several passes. Returns how many cells of the map of empty space were
    /// looked at.
    std::size_t refine(const FieldSource& source);

    March& march() { return march_; }
    /// What it was made with.
    std::uint32_t features() const { return features_; }

  private:
    const PreparedScene& scene_;
    Ledger& gpu_;
    std::uint32_t features_;
    std::size_t rayCount_;
    March march_;
};

} // namespace tessera
