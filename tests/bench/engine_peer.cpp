// tests/bench/engine_peer.cpp: see engine_peer.h.
#include "tests/bench/engine_peer.h"

#include "core/base/error.h"
#include "render/backends/engine_maker.h"
#include "render/picture/picture.h"
#include "render/plan/planner.h"

#include <sstream>

namespace tessera::bench {
namespace {

constexpr std::size_t kBudgetBytes = std::size_t{6} << 30; // wide: no benchmark is about budgets

} // namespace

std::vector<EngineKind> parseEngines(const std::string& text, const std::string& option) {
    std::vector<EngineKind> kinds;
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, ',');)
        kinds.push_back(engineNamed(part, option, false));
    return kinds;
}

struct EnginePeer::Loaded {
    MemoryBudget ram{"RAM", "--ram", kBudgetBytes}, gpu{"GPU memory", "--gpu-memory", kBudgetBytes};
    Planner plan;
    std::shared_ptr<Engine> engine;
    std::unique_ptr<RayCaster> caster; // after the engine, which outlives it
};

EnginePeer::EnginePeer(EngineKind kind, const Scene& scene, const StoreReader& store,
                       const std::string& device)
    : loaded_(std::make_unique<Loaded>()) {
    thread_.run([&] {
        Loaded& l = *loaded_;
        RenderOptions options;
        options.engine = kind;
        options.device = GlDeviceChoice{device};
        l.engine = makeEngine(options, l.ram, l.gpu);
        device_ = l.engine->about().device;
        l.plan = planScene(scene, store, l.engine->limits(), {l.ram, l.gpu, options.threads},
                           LevelChoice::oneForAll, pictureBytesPerPixel(kind));
        Work loading;
        const bool passes = loadBricks(*l.engine, l.plan, l.gpu, loading);
        if (passes || l.plan.layer().selection.finest() != 0)
            throw InputError("the volume does not fit " + device_ + " at full resolution");
        l.caster = l.engine->caster({}, l.gpu);
        l.caster->refine();
    });
}

EnginePeer::~EnginePeer() {
    thread_.run([&] { loaded_.reset(); });
}

void EnginePeer::draw(RayCaster& caster, Work& work) {
    caster.begin(raysOf(loaded_->plan));
    drawToTheEnd(caster, *loaded_->engine, loaded_->plan, Slicing{}, work);
    if (const std::string fault = loaded_->engine->fault(); !fault.empty())
        throw Error(fault);
}

double EnginePeer::drawMs(double stepVoxels) {
    double ms = 0;
    thread_.run([&] {
        Loaded& l = *loaded_;
        l.plan.setStep(stepVoxels);
        Work work;
        const auto start = Clock::now();
        draw(*l.caster, work);
        picture_ = l.caster->image();
        ms = msSince(start);
    });
    return ms;
}

Work EnginePeer::count(double stepVoxels) {
    Work work;
    thread_.run([&] {
        Loaded& l = *loaded_;
        l.plan.setStep(stepVoxels);
        CasterOptions options;
        options.counting = true;
        const auto caster = l.engine->caster(options, l.gpu);
        caster->refine();
        draw(*caster, work);
    });
    return work;
}

} // namespace tessera::bench
