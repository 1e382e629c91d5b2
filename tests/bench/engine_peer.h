// tests/bench/engine_peer.h: any engine of Tessera beside other renderers: a scene at full resolution, drawn
// with any step, by the program's own path (render/picture/picture.h).
#pragma once

#include "core/image/image.h"
#include "core/scene/scene.h"
#include "render/engine.h"
#include "render/picture/render_scene.h"
#include "tests/bench/bench_tools.h"
#include "tests/bench/gl_thread.h"

#include <memory>
#include <string>
#include <vector>

namespace tessera::bench {

/// Kinds by the names that the program knows, with commas between. Throws InputError for a name that is none.
std::vector<EngineKind> parseEngines(const std::string& text, const std::string& option);

/// It lives on a thread of its own, where an engine's GL context may stay current beside VTK's.
class EnginePeer {
  public:
    /// Loads all bricks. Throws InputError where they do not fit at the finest level.
    /// @param scene   its camera spelled out
    /// @param device  for engines on a GPU
    EnginePeer(EngineKind kind, const Scene& scene, const StoreReader& store, const std::string& device);
    ~EnginePeer();
    EnginePeer(const EnginePeer&) = delete;
    EnginePeer& operator=(const EnginePeer&) = delete;

    std::string device() const { return device_; }
    /// Milliseconds by the clock: rays made anew, drawn to their end, and the float picture taken to the
    /// host.
    double drawMs(double stepVoxels);
    /// Of the last frame.
    const Image& picture() const { return picture_; }
    /// What a frame takes, where the engine counts; counting takes time, so it is a frame of its own.
    Work count(double stepVoxels);

  private:
    struct Loaded;
    void draw(RayCaster& caster, Work& work);

    GlThread thread_; // first: all that is loaded goes on it
    std::unique_ptr<Loaded> loaded_;
    std::string device_;
    Image picture_;
};

} // namespace tessera::bench
