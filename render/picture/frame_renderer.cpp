// render/picture/frame_renderer.cpp: see frame_renderer.h.
#include "render/picture/frame_renderer.h"

#include "core/base/error.h"
#include "render/picture/draw_scene.h"
#include "render/plan/label_optics.h"
#include "render/plan/planner.h"

#include <array>
#include <optional>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// The same but for the camera.
bool sameButCamera(const Scene& a, const Scene& b) {
    Scene x = a, y = b;
    x.camera = y.camera = Camera{};
    return sceneJson(x) == sceneJson(y);
}

/// RAM that was never used, where bricks are kept: planning a picture takes about as much as planning the one
/// before.
constexpr std::size_t kAmpleBytes = std::size_t{64} << 20;

} // namespace

struct FrameRenderer::State {
    std::vector<const StoreReader*> stores;
    MemoryBudget &ram, &gpu;
    RenderOptions options;
    /// The engine's RAM must not affect the plan of the next picture, as it does not for a still. So it is
    /// charged to ram while a picture is drawn.
    MemoryBudget engineRam;
    std::optional<RendererInstance> made;
    Planner p; // stays where it is: the engine was opened for it
    std::optional<Scene> last;
    std::optional<KnownLayer> known; // read for the last picture
    Charge heldRam;
    std::size_t gpuBefore = 0; // in use when the engine holds nothing
    FrameReuse reuse;          // kept: the engine holds bricks of the last picture

    State(Stores readers, MemoryBudget& ramBudget, MemoryBudget& gpuBudget, const RenderOptions& given)
        : stores(readers.begin(), readers.end()), ram(ramBudget), gpu(gpuBudget), options(given),
          engineRam(ram.name(), ram.option(), ram.limitBytes()) {
        reuse.opened = [this] {
            heldRam = {};
            heldRam = ram.charge(engineRam.usedBytes(), "the brick index");
        };
    }
    Planner plan(const Scene& scene, const TextureLimits& limits, LevelChoice choice,
                 const PixelMemory& pixels) {
        // As if the engine held nothing.
        MemoryBudget free(gpu.name(), gpu.option(), gpu.limitBytes());
        const Charge before = free.charge(gpuBefore, "the device");
        std::optional<KnownLayer> mine = std::exchange(known, std::nullopt);
        return planScene(scene, *stores.front(), limits, {ram, free, options.threads}, choice, pixels,
                         mine ? &*mine : nullptr);
    }
    /// True if the bricks of the last picture serve this one.
    /// @param pageEdge, levels  of the last picture
    bool serves(const FramePlan& plan, int pageEdge, const std::vector<std::uint8_t>& levels) const {
        const BrickResidency* const bricks = made->renderer->bricks();
        return bricks && bricks->pages() >= plan.chosen.atlasPages && holdsAll(plan) &&
               plan.layer().pageEdge == pageEdge &&
               // light of voxels is that of the bricks as they are
               (lightChannels(plan.view.lighting) == 0 || levels == plan.layer().selection.levels) &&
               gpu.usedBytes() + plan.memory.gpuBytes() <= gpu.limitBytes();
    }
    /// Room for a quarter more bricks than the picture has, where there is any.
    std::size_t roomyPages(const FramePlan& plan, TextureLimits limits) const {
        if (!holdsAll(plan))
            return 0;
        limits.pageEdge = plan.layer().pageEdge;
        limits.channelsBeside = plan.channelsBeside();
        const std::size_t fixed = gpuBefore + plan.memory.gpuBytes();
        const std::size_t fit =
            pagesThatFit(gpu.limitBytes() - std::min(gpu.limitBytes(), fixed), plan.info().type, limits);
        return std::min(fit, plan.chosen.atlasPages + plan.chosen.atlasPages / 4 + 16);
    }
    /// Every brick has its place, at levels that no picture decides about.
    static bool holdsAll(const FramePlan& plan) {
        return !plan.chosen.chooser && plan.chosen.atlasPages >= pagesFor(plan.layer().selection.counts);
    }
};

FrameRenderer::FrameRenderer(Stores stores, MemoryBudget& ram, MemoryBudget& gpu,
                             const RenderOptions& options)
    : state_(std::make_unique<State>(stores, ram, gpu, options)) {
    TESSERA_CHECK(!options.onFirstPicture && !options.tiles);
}

FrameRenderer::FrameRenderer(const StoreReader& store, MemoryBudget& ram, MemoryBudget& gpu,
                             const RenderOptions& options)
    : FrameRenderer(std::array{&store}, ram, gpu, options) {}

FrameRenderer::~FrameRenderer() {
    forget();
}

void FrameRenderer::forget() {
    State& s = *state_;
    if (s.made)
        s.made->renderer->close();
    s.reuse.kept = false;
    s.heldRam = {};
}

RenderResult FrameRenderer::draw(const Scene& given) {
    State& s = *state_;
    // Measuring errors has another plan opened; of several volumes nothing stays.
    if (s.options.verify != Verify::none || s.stores.size() > 1 || hasLabelOptics(given)) {
        ++kept_.frames;
        return renderScene(given, s.stores, s.ram, s.gpu, s.options);
    }
    const Scene scene = asDrawn(given);
    if (!s.made) {
        s.made.emplace(s.options, s.engineRam, s.gpu);
        s.gpuBefore = s.gpu.usedBytes();
    }
    if (!whyNotDrawn(scene, s.made->kind, s.options).empty()) { // another engine, or none
        forget();
        s.p = Planner(); // its memory is that of the other engine
        s.known.reset();
        s.last.reset();
        ++kept_.frames;
        return renderScene(given, s.stores, s.ram, s.gpu, s.options);
    }
    Renderer& renderer = *s.made->renderer;
    const bool isSame = s.last && sameButCamera(*s.last, scene);
    if (s.reuse.kept && !isSame)
        forget();
    const int pageEdge = s.p.layer().pageEdge;
    const std::vector<std::uint8_t> levels = std::move(s.p.layer().selection.levels);
    if (std::exchange(s.last, std::nullopt))
        s.known = KnownLayer::of(s.p.layer());
    if (s.known && !isSame) // other looks, perhaps
        s.known->labelBricks.reset(), s.known->labels.reset(), s.known->sliceLabels.reset();
    s.heldRam = {};
    s.p = Planner(); // gives back the memory of the last picture, as if it had never been
    try {
        const auto planned = [&](const Scene& first, const TextureLimits& limits, LevelChoice choice,
                                 const PixelMemory& pixels) {
            Planner p = s.plan(first, limits, choice, pixels);
            if (s.reuse.kept && !s.serves(p, pageEdge, levels))
                forget();
            s.reuse.pages = s.roomyPages(p, limits);
            return p;
        };
        RenderResult result =
            drawScene(scene, s.p, *s.made, {s.ram, s.gpu, s.options.threads, s.options.progress}, s.options,
                      s.reuse, planned);
        ++kept_.frames;
        kept_.goneOn += s.reuse.kept ? 1 : 0;
        kept_.brought += result.work.bytesUploaded;
        s.last = scene;
        s.reuse.kept = renderer.bricks() && State::holdsAll(s.p) &&
                       s.p.view.quality.maxError.value_or(0) == 0 &&
                       s.ram.limitBytes() - s.ram.peakBytes() >= kAmpleBytes + s.engineRam.usedBytes();
        s.p.layer().cache.reset();
        if (!s.reuse.kept)
            forget();
        return result;
    } catch (...) {
        forget();
        s.p = Planner();
        s.known.reset();
        throw;
    }
}

} // namespace tessera
