// render/backends/native/packet.h: the inputs of a packet of rays, as plain numbers and pointers. The text
// that draws packets is compiled once for every instruction set (packet_march.h). Nothing that it includes
// may bring functions which a linker could share with the rest of the program.
#pragma once

#include "render/contract/scene_numbers.h"

#include <cstddef>
#include <cstdint>

namespace tessera::native {

constexpr int kMostLanes = 32;
constexpr int kMostSurfaces = 8;

enum class SampleKind { i16, u16, f32 };
/// As Gradient and Integrator of core/scene/scene.h.
enum class PacketGradient { central, centralHalf, forward, sobel, analytic, cubic };
enum class PacketIntegrator { midpoint, linear, preintegrated, preintegrated2d };
/// As Reduction of core/scene/mode.h.
enum class PacketReduction { composite, maximum, minimum, average };
constexpr int kMostPacketSlabs = 8; // as kMostSlabs of render/contract/ray.h

/// The place of a brick's samples, and the cells of its lattice that need no other brick.
struct PacketBrick {
    /// Of sample (0,0,0) of the brick among all samples.
    std::uint32_t base = 0;
    /// Cells from low up to, not with, high; each 8 + a byte, x lowest. The top byte of low is the level, or
    /// kValue where the brick stands as one value, or kAbsent.
    std::uint32_t low = 0, high = 0;
    float mean = 0;
    static constexpr std::uint32_t kValue = 64, kAbsent = 128;
};

struct PacketField {
    const void* samples = nullptr;
    SampleKind kind = SampleKind::i16;
    const PacketBrick* bricks = nullptr; // [z][y][x]
    std::int32_t grid[3] = {};           // bricks
    std::int32_t extentVoxels[3] = {}, lastVoxel[3] = {};
    std::int32_t rowPitch[6] = {}, slicePitch[6] = {}; // samples, by level
    bool mixed = false;
    std::int32_t level = 0;    // for one level: of all bricks
    std::int32_t last[3] = {}; // of its samples
    // Mixed levels (render/contract/level_map.h)
    const std::uint32_t* corners = nullptr; // two words each
    const std::uint32_t* facts = nullptr;   // a word a brick
    std::int32_t edgeFunction = 0;
    std::int32_t finest = 0;
    // Strides
    std::int32_t uniformSegments = 1, mostStride = 0;
    bool naive = false;
    float segmentVoxels = 1;
};

struct PacketOptics {
    // The transfer function's table, and where values are in it
    const float* table = nullptr; // four an entry: red, green, blue, extinction per mm
    float scale = 0, offset = 0;
    std::int32_t last = 0;      // of its entries
    std::int32_t lastEntry = 0; // the one before, and the last as a place
    float lastPlace = 0;
    float termination = 0; // 0: never
    PacketReduction reduction = PacketReduction::composite;
    bool keepsOn = false; // more of the rays comes: their kept value is not made a colour
    PacketIntegrator integrator = PacketIntegrator::midpoint;
    const float* bins = nullptr;    // four a bin
    const float* sums = nullptr;    // preintegrated: four each
    const float* colours = nullptr; // preintegrated2d: four each
    float preintegrationScale = 0;
    std::int32_t preintegrationEdge = 0, firstLayer = 0;
    // Light
    bool lit = false;
    PacketGradient gradient = PacketGradient::central;
    float normalReach = 1; // above 1: normals are Sobel's over so many pitches
    float ambient = 0, diffuse = 0, specular = 0;
    std::int32_t power = 1;
    float toGradient[9] = {}, toPatient[9] = {}; // column by column
    bool hasLights = false;                      // of the scene's own
    leaf::LightingNumbers lighting;
    std::int32_t materialCount = 0;
    leaf::MaterialNumbers materials[leaf::kMostMaterials]; // from and to as places in the table
    leaf::GradientNumbers<float> gradientOpacity;
    leaf::LabelNumbers labels;
};

struct PacketEmptySpace {
    const std::uint64_t* map = nullptr; // null: nothing is skipped (render/empty_space/distance_map.h)
    std::int32_t grid[3] = {};
    std::int32_t shift = 3; // log2 of a box's edge, voxels
    /// A texel of 0 is not tested yet (fine_blocks.h); look() tests it.
    const void* finer = nullptr; // null: no texel is 0
    void (*look)(const void* finer, std::int32_t number) = nullptr;
};

/// The ranges of values in bricks and in cells (render/empty_space/value_bounds.h).
struct PacketBounds {
    const float* brick = nullptr; // null: nothing is leapt over
    const float* cell = nullptr;  // null: bricks only
    std::int32_t cells[3] = {};
    bool least = false; // rays keep the least value
};

/// Isosurfaces, by value, ascending.
struct PacketSurfaces {
    std::int32_t count = 0;
    float isovalue[kMostSurfaces] = {}; // as stored
    float red[kMostSurfaces] = {}, green[kMostSurfaces] = {}, blue[kMostSurfaces] = {};
    float opacity[kMostSurfaces] = {};
    float reports[kMostSurfaces] = {}; // above 0: rays keep their first hit among such surfaces
    bool volumeShows = true;           // between them
    bool showsDistances = false;       // distances along rays, mm, in place of red; of the volume too
    PacketEmptySpace space;            // of the surfaces alone; no map: wherever anything shows
};

struct PacketJob;

/// Rare work is left to the scalar text of render/contract. All thread-safe.
struct PacketHelp {
    const void* context = nullptr;
    /// @param missing  set where a brick is absent
    void (*gradient)(const void* context, const float* p, float* gradient, bool* missing) = nullptr;
    /// True if the packet must stop now.
    bool (*expired)(const void* context) = nullptr;
};

struct PacketFusion;

struct PacketScene {
    const PacketFusion* fusion = nullptr; // of several volumes, the first of which this is; null: it is alone
    PacketField field;
    PacketField light[leaf::kMostLightChannels];  // as many as optics.lighting says; at the same places
    PacketField labels[leaf::kMostLabelChannels]; // as many as optics.labels says
    PacketOptics optics;
    PacketEmptySpace space;
    PacketBounds bounds;
    PacketSurfaces surfaces;
    PacketHelp help;
};

constexpr int kMostVolumes = 8;
/// Several volumes under rays of a lattice of their own (Fusion in render/plan/fusion.h).
struct PacketFusion {
    std::int32_t count = 0;    // of volumes
    std::int32_t rule = 0;     // leaf::kFusion...
    std::int32_t segments = 1; // a stride, a power of two
    const PacketScene* volumes[kMostVolumes] = {};
    /// From a place of the lattice to a volume's voxels: the linear part column by column; what is added.
    float linear[kMostVolumes][9] = {}, offset[kMostVolumes][3] = {};
    float unitMm[kMostVolumes] = {};              // unit distances of the functions
    const leaf::CutSlab* cuts[kMostVolumes] = {}; // of each volume alone
    std::int32_t cutCount[kMostVolumes] = {};     // slabs of them
};

/// As SurfaceHit of render/contract/ray_state.h.
struct PacketHits {
    alignas(64) float position[3][kMostLanes];
    alignas(64) float weight[kMostLanes];
    alignas(64) float normal[3][kMostLanes];
    alignas(64) std::int32_t surface[kMostLanes];
};

/// Rays side by side, and how far they are.
struct PacketJob {
    alignas(64) float entry[3][kMostLanes];
    alignas(64) float step[3][kMostLanes];
    alignas(64) float direction[3][kMostLanes];
    alignas(64) float segmentMm[kMostLanes];
    alignas(64) float tail[kMostLanes];
    alignas(64) std::int32_t count[kMostLanes];
    alignas(64) std::int32_t next[kMostLanes]; // segment; count at the ray's end
    alignas(64) float colour[4][kMostLanes];   // premultiplied; alpha
    std::uint32_t waiting = 0;                 // bits: lanes whose next sample needs a brick that is absent
    PacketHits* hits = nullptr;                // null: nobody asks
    std::int32_t turns = 0; // of its loop that the packet may take; then it stops where it is
    std::uint64_t iterations = 0, segments = 0, values = 0, gradients = 0; // as Work counts them
    std::uint64_t turnsTaken = 0;                                          // that took samples
};

/// As RayFrame of render/contract/ray.h.
struct PacketFrame {
    float centre[3], right[3], up[3], toCentre[3];
    float patientFromVoxel[9]; // column by column
    float extent[3];
    float imageSize[2];
    float segmentVoxels = 1;
    bool perspective = true;
    struct Slab {
        float normal[3], low, high;
    };
    Slab slabs[kMostPacketSlabs];
    std::int32_t slabCount = 0;
    bool flat = false;
};

/// The places of a packet's rays on the picture, pixels, and their phases (phaseOf() in
/// render/contract/ray.h).
struct PacketPlaces {
    alignas(64) float x[kMostLanes];
    alignas(64) float y[kMostLanes];
    alignas(64) float phase[kMostLanes];
};

/// The samples of a cell of 8^3 voxels and one layer around it, rows along x, y fastest.
struct CellSamples {
    alignas(64) float rows[100][16]; // ten of each are used; the others repeat one of them
};
/// Those that one brick has.
struct CellRows {
    std::int64_t alongY[10], alongZ[10]; // samples after its first; along z: of the row's number 0, too
    std::int32_t firstY = 0, endY = 0;   // rows
    std::int32_t firstZ = 0, endZ = 0;   // slices
    std::int32_t first = 0, last = 0;    // numbers of a row
    bool alone = true;                   // the other numbers repeat the outermost; else they stay
    float scale = 1, offset = 0;         // from samples as they are stored
};
/// Least and largest value of the field in each block of 2^3 voxels (x + 4y + 16z), and of all samples.
struct CellRanges {
    alignas(64) float blockLow[64];
    alignas(64) float blockHigh[64];
    float low, high;
};

/// Samples that are lit side by side.
constexpr int kOcclusionRun = 16;
/// As OcclusionMethod of core/scene/lighting.h.
enum class OcclusionSum { local, positional, rejecting };
/// The fall of opacity that is rejected: more than the rounding in an even medium.
constexpr float kRejectedFall = 1.0f / 1048576;
/// A place that a ray of occlusion reads: between four samples of a layer of the lattice. Its value stands
/// for the step around it; the first and the last of a ray for half a step.
struct OcclusionStep {
    std::int32_t offset = 0; // of the first of them from the sample that is lit
    float weight[4] = {};    // of it, of those strideA and strideB on, and of the one across
};
struct OcclusionPath {
    const OcclusionStep* steps = nullptr;
    std::int32_t count = 0; // of places that are read, two or more: one more than steps
    std::int32_t strideA = 0, strideB = 0;
    float share = 0; // local: of half a step in the mean over all rays; else of a ray
    float part = 0;  // weight among all rays
    float direction[3] = {};
};
/// Weights of rays by surfaces, of a run of samples.
struct OcclusionNormals {
    const float* normal[3] = {}; // four times the share w of a surface, unit normal
    const float* rest = nullptr; // 1 - w
    float* weights = nullptr;    // adds the rays' weights
};

/// The light left along a packet's rays of a shadow map.
struct PacketShadows {
    alignas(64) float mmAtEntry[kMostLanes];
    float dark = 0;                        // light below which a ray ends
    float* out[kMostLanes] = {};           // pairs of a distance, mm, and light: at most two a segment
    std::int32_t written[kMostLanes] = {}; // pairs
};

/// A deep shadow map seen in parallel, and a run of places on it (render/light/shadow_maps.h).
struct ShadowLook {
    const float* rays = nullptr; // kNumbersOfRay each, row by row
    std::int32_t size = 0;       // rays along either side
    double place[3], step[3];    // of the first place, and from one to the next
    double offset[3];            // on to where it is looked up
    double centre[3], right[3], up[3], forward[3];
};
/// Eight distances, ascending, and the light left there.
constexpr int kNumbersOfRay = 16;

/// Bounds of extinction (render/empty_space/extinction_bounds.h).
struct PacketExtinction {
    const std::uint32_t* cells = nullptr;      // of 8^3 voxels
    const std::int32_t* parts = nullptr;       // null: no cell has any
    const std::uint32_t* partRanges = nullptr; // eight a cell that has parts
    std::int32_t grid[3] = {};                 // cells
    float limit = 0;
};
/// Ways of light, one beside another: those of Way and PathNumbers.
struct PacketWays {
    std::int32_t count = 0;
    const float* from[3] = {};
    const float* perMm[3] = {};
    const float* mm = nullptr;
    const std::uint32_t *first = nullptr, *second = nullptr; // of random numbers
    std::uint32_t* draws = nullptr;                          // go on
    /// Free paths: mm to the first collision, below 0 where there is none; transmittances.
    float* result = nullptr;
    std::uint64_t lookUps = 0, nullCollisions = 0, cells = 0, exceeded = 0; // as PathWork counts them
};
/// Of scenes all of whose bricks are there.
using PacketWaysMarch = void (*)(const PacketScene&, const PacketExtinction&, PacketWays&);

/// A list of places, voxels, and what the field has there; with room for kMostLanes more.
struct PacketSamples {
    std::int32_t count = 0;
    const float* at[3] = {};
    float* value = nullptr;
    float* gradient[3] = {};                       // null: not wanted
    PacketGradient kind = PacketGradient::central; // not analytic or cubic
};
/// Of a packet's rays, where they have gathered an opacity.
struct PacketSeen {
    alignas(64) float sought[kMostLanes];
    alignas(64) float alpha[kMostLanes];     // gathered in parts of the rays before; goes on
    alignas(64) float place[3][kMostLanes];  // voxels
    alignas(64) float colour[3][kMostLanes]; // of the function
    std::uint32_t shows = 0, found = 0;      // bits: rays that show anything, and those that are at the place
    std::uint64_t segments = 0;
};
/// By the midpoint rule, of scenes all of whose bricks are there.
struct PacketPlaceTools {
    void (*samples)(const PacketScene&, PacketSamples&) = nullptr;
    void (*seek)(const PacketScene&, const PacketJob&, PacketSeen&) = nullptr;
};

using PacketMarch = void (*)(const PacketScene&, PacketJob&);
using PacketShadowMarch = void (*)(const PacketScene&, PacketJob&, PacketShadows&);

/// The functions compiled for one instruction set.
struct PacketTarget {
    const char* name = "";
    int columns = 0, rows = 0; // pixels of a packet
    int lanes() const { return columns * rows; }
    PacketMarch (*march)(const PacketScene&) = nullptr;
    /// Of scenes with a fusion.
    PacketMarch fused = nullptr;
    /// Through places on the picture, a lane each: x right, y down, pixels.
    void (*rays)(const PacketFrame&, const PacketPlaces&, PacketJob&) = nullptr;
    /// @param samples  the brick's first
    void (*cellSamples)(const void* samples, SampleKind kind, const CellRows&, CellSamples&) = nullptr;
    void (*cellRanges)(const CellSamples&, CellRanges&) = nullptr;
    /// Of a step through samples of an extinction.
    /// @param count  a multiple of kOcclusionRun
    void (*opacities)(const float* extinction, int count, float stepMm, float* out) = nullptr;
    /// Adds the light that gets to each of a run of samples.
    /// @param opacity  of the first one, of paths whose steps are of one length
    /// @param normals  null: of all directions alike
    void (*occlude)(const float* opacity, const OcclusionPath* paths, int count, OcclusionSum sum,
                    const OcclusionNormals* normals, float* light) = nullptr;
    /// The same, local, where tissue sends light too: adds that, red, green and blue.
    /// @param emission  of the sample of opacity, laid out alike
    void (*occludeAndShine)(const float* opacity, const float* const (&emission)[3],
                            const OcclusionPath* paths, int count, float* light,
                            float* const (&shine)[3]) = nullptr;
    /// Light through a volume without surfaces. Where a brick is absent, job.waiting is not 0 and nothing
    /// holds.
    PacketShadowMarch (*shadows)(const PacketScene&) = nullptr;
    /// Adds the light that a map leaves at a run of kOcclusionRun places.
    void (*addShadows)(const ShadowLook&, float* light) = nullptr;
    /// Ways of light: free paths, or transmittances.
    PacketWaysMarch (*ways)(const PacketScene&, bool free) = nullptr;
    PacketPlaceTools (*places)(const PacketScene&) = nullptr;
    /// For measurements: the cost of trilinear samples and nothing else: so many turns along rays inside a
    /// brick of level 0. Adds the values to job.colour[0].
    void (*bareSamples)(const PacketScene&, const std::int32_t (&brick)[3], int turns,
                        PacketJob& job) = nullptr;
};
extern const PacketTarget kBaselineTarget, kAvx2Target, kAvx512Target;

/// Those that were compiled and that this processor has, the narrowest first; null beyond them.
struct PacketTargets {
    const PacketTarget* all[3] = {};
    int count = 0;
};
PacketTargets packetTargets();
/// The widest; or the one that the environment's TESSERA_INSTRUCTIONS names, where it is among them.
const PacketTarget& packetTarget();

} // namespace tessera::native
