// tests/support/accuracy_fixture.h: a plain scene, and sweeps whose numbers are made up.
#pragma once

#include "tests/bench/accuracy/sweep.h"

#include <string>
#include <tuple>

namespace tessera::accuracy {

inline Scene plainScene() {
    Scene scene;
    scene.volumes = {{"v.zarr", std::string("bone-1")}};
    scene.shading.on = false;
    return scene;
}

/// A sweep whose numbers are made up: errors and times of two settings.
inline Sweep madeUp(const std::string& name, double fastError, double slowError) {
    Sweep sweep;
    sweep.scene = {name, "", plainScene(), 0};
    for (const auto& [step, error, ms] :
         {std::tuple(1.0, fastError, 10.0), std::tuple(0.5, slowError, 20.0)}) {
        Measured m;
        m.planned.setting = settingOf(plainScene());
        m.planned.setting.detail = {};
        m.planned.setting.integrator = Integrator::midpoint;
        m.planned.setting.stepVoxels = step;
        m.error.rmse = error;
        m.blocks = {{{ms + 1, ms}, ms}, {{ms + 2}, ms}};
        sweep.measured.push_back(m);
    }
    return sweep;
}

} // namespace tessera::accuracy
