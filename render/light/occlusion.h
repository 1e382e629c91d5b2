// render/light/occlusion.h: local ambient occlusion of the samples of a level (course notes 6.1): the share
// of a sphere's light that reaches each. It is a function of the volume, its transfer function and the level
// alone. Levels of neighbouring bricks do not matter (docs/sampling.md, "Light per voxel").
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/statistics/statistics.h"
#include "core/scene/transfer_function.h"
#include "render/backends/native/packet.h"
#include "render/contract/optics.h"
#include "render/geometry/mesh_bits.h"
#include "render/labels/drawn_labels.h"
#include "render/light/directions.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

/// Samples of a chunk and of its surroundings within reach of rays: the working set of a thread.
class OcclusionRoom {
  public:
    /// Reach of interpolation near a sample, in samples, with or without mixed levels.
    static constexpr int kAround = 2;
    static constexpr int kRun = native::kOcclusionRun, kRunsPerRow = kChunkExtent / kRun;

    /// For rays with this reach.
    /// @param emits  tissue may emit light
    /// @param surfaces  rays are weighted by surfaces
    /// @param meshes  take light, too
    explicit OcclusionRoom(const glm::ivec3& reach, bool emits = false, bool surfaces = false,
                           bool meshes = false);
    static std::size_t bytes(const glm::ivec3& reach, bool emits = false, bool surfaces = false,
                             bool meshes = false);

    glm::ivec3 reach, size; // samples before the chunk; all
    std::vector<float> extinction, opacity;
    std::vector<float> ofMeshes; // their extinction, in the same layout, if they take light
    /// If they do, opacity and emission have the chunk's layers once more, without meshes: so far behind
    /// each.
    std::size_t toOwn() const { return extinction.size() - cellCount({size.x, size.y, reach.z}); }
    /// For every row along x: true if it has extinction of any kind; true if opacity is filled there.
    std::vector<std::uint8_t> rowShows, rowIsSet;
    /// Level 0: range of stored values along every run of samples and two more at either end.
    std::vector<float> low, high;
    std::vector<float> light; // of the chunk's samples
    /// Red, green, blue, if tissue may emit light: emission, in the layout of extinction; light received by
    /// samples.
    std::array<std::vector<float>, 3> emission, shine;

    /// Of the chunk's samples, if rays are weighted by surfaces: OcclusionNormals.
    std::array<std::vector<float>, 3> normal;
    std::vector<float> rest, weights;

    /// A run of kOcclusionRun adjacent samples to light.
    struct Run {
        glm::ivec3 at;        // the first, in the chunk
        std::size_t from, to; // the first, in opacity and in light
    };
    std::vector<Run> runs;
};

/// Extinctions of the samples of whole chunks, those used last: a chunk's rays read all chunks around it. For
/// several threads.
class ChunkExtinctions {
  public:
    static constexpr std::size_t kMost = 128; // chunks with extinction
    /// Memory of those of such a volume, and of one that each thread still reads.
    static std::size_t bytes(const VolumeInfo& info, int threads);

    struct Samples {
        std::unique_ptr<float[]> extinction; // in the chunk's layout; none: nowhere any
        std::vector<std::uint8_t> rowShows;  // every row along x: it has some
    };
    /// @param make  called where a chunk is not kept: fills its samples, a function of the key alone. It may
    /// read others of other objects.
    std::shared_ptr<const Samples> get(const ChunkKey& key, const std::function<void(Samples&)>& make);
    void clear();

  private:
    struct Kept {
        Samples samples;
        std::once_flag isMade;
        std::uint64_t used = 0;
    };
    std::mutex mutex_;
    std::map<ChunkKey, std::shared_ptr<Kept>> kept_;
    std::uint64_t turn_ = 0;
};

/// Light that gets to samples, for tissue that scatters it.
class LightOfSamples {
  public:
    virtual ~LightOfSamples() = default;
    /// Of samples of a level side by side along x.
    /// @param first  of them; none is beyond the level's samples
    /// @param out    red, green and blue, one a sample
    virtual void at(int level, const glm::ivec3& first, std::span<glm::vec3> out) const = 0;
};

/// Where the bits of meshes lie that take a volume's light: on the lattice of one of its levels.
struct MeshLattice {
    VoxelGrid grid;
    int level = 0;
};
/// The finest of occlusion's levels and above where bits and alphas take at most 64 MiB, or the coarsest.
MeshLattice meshLattice(const VolumeInfo& info, const Occlusion& occlusion,
                        std::span<const SceneMesh> meshes);

class Occluder {
  public:
    /// All must outlive it.
    /// @param occlusion  none: only finds runs, for other light
    /// @param target  instruction set; null: the processor's best
    Occluder(const VolumeInfo& info, const Statistics& statistics, const std::optional<Occlusion>& occlusion,
             const native::PacketTarget* target = nullptr);
    /// Labels, or null; they outlive this. setFunction() must follow.
    void setLabels(const DrawnLabels* labels) { labels_ = labels; }
    /// Another volume, whose tissue takes this one's light too. Its function is set; both outlive this, or
    /// the next call.
    struct Other {
        const Occluder* tissue;
        BrickCache* cache;
    };
    /// Call it again where a function of theirs is another.
    void setOthers(std::vector<Other> others);
    /// Meshes that take this volume's light too; null: none. They outlive this, or the next call.
    /// @param level  bits are those of its lattice
    void setMeshes(const MeshBits* bits, int level);
    /// Tissue sends what it scatters of this light, in place of its materials' own. The light outlives this;
    /// setFunction() must follow.
    void setScattered(const LightOfSamples* light) { scattered_ = light; }
    /// Sets the transfer function.
    void setFunction(const TransferTable& table, const Optics& optics);

    /// Largest memory of a thread.
    glm::ivec3 mostReach() const;
    /// Finest level with light of its own; finer levels use this one's.
    int finestLevel() const { return finest_; }
    const native::PacketTarget& target() const { return target_; }
    /// True if emitted light is gathered too.
    bool gathersEmission() const { return strength_ > 0; }
    /// True if meshes take light.
    bool meetsMeshes() const { return meshes_ != nullptr; }
    /// True if rays are weighted by surfaces.
    bool seesSurfaces() const { return surfaces_; }

    /// Reads a chunk and its surroundings, and finds the runs of samples within two samples of visible ones.
    /// @param bricks  of the chunk, x fastest: those to light; empty: all
    /// @param occludes  occlude() follows; else only data for visibility are read
    void find(const ChunkKey& chunk, std::span<const std::uint8_t> bricks, bool occludes, BrickCache& cache,
              OcclusionRoom& room) const;
    /// Computes the unoccluded share of each sample of these runs, equation 6.3, in room.light; 1 elsewhere.
    /// Emitted light (6.5) is in room.shine; 0 elsewhere.
    void occlude(const ChunkKey& chunk, OcclusionRoom& room) const;
    /// The same for the runs that another found, whose reach may differ; reads what is around the chunk.
    void occlude(const ChunkKey& chunk, const OcclusionRoom& found, BrickCache& cache,
                 OcclusionRoom& room) const;

  private:
    struct Range { // of stored values
        float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
        std::uint8_t shows = 0; // ShownPart
        void add(float least, float most, std::uint8_t part) {
            low = std::min(low, least);
            high = std::max(high, most);
            shows |= part;
        }
    };
    void read(const ChunkKey& chunk, bool occludes, BrickCache& cache, OcclusionRoom& room) const;
    void findNormals(OcclusionRoom& room) const;
    using SharedSamples = std::shared_ptr<const ChunkExtinctions::Samples>;
    SharedSamples extinctionsOf(const ChunkKey& key, BrickCache& cache) const;
    SharedSamples ownExtinctions(const ChunkKey& key, BrickCache& cache) const;
    void add(const Other& other, const ChunkKey& key, float* extinction) const;
    bool othersLetThrough(const ChunkKey& chunk) const;
    void readMeshes(const ChunkKey& chunk, OcclusionRoom& room) const;
    template <typename Stored>
    void fillExtinctions(const ChunkKey& key, const Chunk& chunk, ChunkExtinctions::Samples& out) const;
    template <typename Stored>
    void readEmission(const glm::ivec3& first, const glm::ivec3& low, const glm::ivec3& high, int level,
                      const Chunk& chunk, OcclusionRoom& room) const;
    glm::vec3 sentBy(float stored) const;
    template <typename Stored>
    void readRanges(const glm::ivec3& first, const glm::ivec3& low, const glm::ivec3& high,
                    const Chunk& chunk, OcclusionRoom& room) const;
    template <typename Stored>
    float gradedExtinction(const Stored* samples, const glm::ivec3& at, const glm::ivec3& last,
                           int level) const;
    void takeLabels(const ChunkKey& key, ChunkExtinctions::Samples& out) const;
    Range rangeAround(const glm::ivec3& sample, int level) const;
    Range rangeOf(const ChunkKey& chunk) const;
    bool nothingNear(const ChunkKey& chunk) const;
    bool isEmpty(const Range& range) const;
    bool letsAllThrough(const Range& range) const;

    const VolumeInfo& info_;
    const Statistics& statistics_;
    const native::PacketTarget& target_;
    int finest_;
    double strength_ = 0; // of emitted light
    bool surfaces_ = false;
    native::OcclusionSum sum_ = native::OcclusionSum::local;
    std::array<OcclusionRays, kLevelCount> rays_;
    const TransferTable* table_ = nullptr;
    const Optics* optics_ = nullptr;
    const DrawnLabels* labels_ = nullptr;
    const LightOfSamples* scattered_ = nullptr; // null: tissue sends its materials' light
    // For every stored value of 16 bits, from the lowest; else empty.
    std::vector<float> extinctionOf_;
    std::vector<glm::vec3> emissionOf_; // empty if nothing is gathered, too
    std::unique_ptr<ChunkExtinctions> extinctions_ = std::make_unique<ChunkExtinctions>();
    std::vector<Other> others_;
    const MeshBits* meshes_ = nullptr;
    int meshLevel_ = 0;
    std::unique_ptr<ChunkExtinctions> withOthers_; // none: there are no other volumes
};

} // namespace tessera
