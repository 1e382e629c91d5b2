// render/engine_maker.cpp: see engine_maker.h.
#include "render/engine_maker.h"

#include "core/error.h"
#include "render/engines/gpu/gpu_engine.h"
#include "render/engines/mirror/mirror_engine.h"
#include "render/engines/native/native_engine.h"

namespace tessera {

const char* name(EngineKind engine) {
    switch (engine) {
    case EngineKind::automatic:
        return "auto";
    case EngineKind::gpu:
        return "gpu";
    case EngineKind::native:
        return "native";
    case EngineKind::mirror:
        return "mirror";
    case EngineKind::reference:
        return "reference";
    }
    return "?";
}

/// OpenGL is not even loaded where the system knows of no GPU.
EngineMaker::EngineMaker(EngineKind asked, const GlDeviceChoice& device, int threads)
    : kind_(asked), threads_(threads) {
    if (kind_ == EngineKind::automatic) {
        kind_ = EngineKind::gpu;
        if (device.text != "auto") {
            reason_ = "a device of OpenGL was asked for";
        } else if (mayHaveGpu()) {
            try {
                context_.emplace(device);
                reason_ = context_->software() ? "OpenGL draws in software here" : "this machine has a GPU";
            } catch (const Error& e) {
                reason_ = e.what();
            }
            if (!context_ || context_->software()) {
                context_.reset();
                kind_ = EngineKind::native;
            }
        } else {
            reason_ = "this machine has no GPU";
            kind_ = EngineKind::native;
        }
    }
    if (kind_ == EngineKind::gpu && !context_)
        context_.emplace(device);
}

std::unique_ptr<Engine> EngineMaker::make(Ledger& ram, Ledger& gpu) const {
    switch (kind_) {
    case EngineKind::gpu:
        return std::make_unique<GpuEngine>(*context_, gpu, ram);
    case EngineKind::native:
        return std::make_unique<NativeEngine>(threads_, gpu, ram);
    case EngineKind::mirror:
        return std::make_unique<MirrorEngine>(threads_);
    case EngineKind::automatic:
    case EngineKind::reference:
        break;
    }
    TESSERA_CHECK(false);
    return nullptr;
}

std::string EngineMaker::about() const {
    const std::string device = context_ ? context_->renderer()
                               : kind_ == EngineKind::native
                                   ? std::string("CPU, ") + native::packetTarget().name
                                   : "CPU";
    return std::string(name(kind_)) + " engine, " + device;
}

std::string EngineMaker::fault() const {
    return context_ && !context_->errors().empty() ? "OpenGL: " + context_->errors().front() : std::string();
}

} // namespace tessera
