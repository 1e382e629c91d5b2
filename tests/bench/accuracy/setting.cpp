// tests/bench/accuracy/setting.cpp: see setting.h.
#include "tests/bench/accuracy/setting.h"

#include "viewer/cli/options/options.h" // formatNumber

#include <algorithm>
#include <cmath>

namespace tessera::accuracy {
namespace {

constexpr double kDisplayTermination = 1.0 / 510; // half a step of 8 bits
constexpr double kFineTermination = 1e-4;

const std::vector<Integrator>& allIntegrators() {
    static const std::vector<Integrator> all = {Integrator::midpoint, Integrator::linear,
                                                Integrator::preintegrated, Integrator::preintegrated2d};
    return all;
}

class Plan {
  public:
    void add(const Setting& setting, const char* axis) {
        const auto same = [&](const Planned& p) { return p.setting == setting; };
        if (std::none_of(list_.begin(), list_.end(), same))
            list_.push_back({setting, axis});
    }
    std::vector<Planned> take() { return std::move(list_); }

  private:
    std::vector<Planned> list_;
};

} // namespace

Setting settingOf(const Scene& scene) {
    Setting s;
    s.stepVoxels = scene.quality.stepVoxels;
    s.integrator = scene.quality.integrator;
    s.fetch = scene.quality.fetch;
    s.termination = scene.quality.terminationTransmittance;
    if (scene.shading.on)
        s.gradient = scene.shading.gradient;
    s.detail.finest = false; // levels as the renderer chooses them for the picture
    s.detail.maxError = scene.quality.maxError;
    s.detail.edgeFunction = scene.quality.edgeFunction;
    return s;
}

Scene withSetting(const Scene& scene, const Setting& setting) {
    Scene out = scene;
    out.quality.stepVoxels = setting.stepVoxels;
    out.quality.integrator = setting.integrator;
    out.quality.fetch = setting.fetch;
    out.quality.terminationTransmittance = setting.termination;
    out.quality.maxError = setting.detail.maxError;
    out.quality.edgeFunction = setting.detail.edgeFunction;
    out.shading.on = setting.gradient.has_value();
    if (setting.gradient)
        out.shading.gradient = *setting.gradient;
    return out;
}

std::vector<Planned> plannedSettings(const Scene& scene, bool quick, const std::vector<Integrator>& only) {
    Plan plan;
    const Setting asIs = settingOf(scene);
    plan.add(asIs, "default");

    std::vector<double> steps = {2, 1, 0.5, 0.25};
    if (!quick)
        steps.insert(steps.end(), {0.125, 0.0625});
    const std::vector<Fetch> fetches = {Fetch::hardware, Fetch::exact};
    const auto addProduct = [&](double step) {
        for (const Integrator integrator : only.empty() ? allIntegrators() : only)
            for (const Fetch fetch : fetches) {
                Setting s = asIs;
                s.detail = {};
                s.integrator = integrator;
                s.fetch = fetch;
                s.stepVoxels = step;
                s.termination = 0;
                plan.add(s, "product");
                // Ending rays early is a saving of its own: what each integrator makes of it, at every step.
                for (const double termination : {kDisplayTermination, kFineTermination}) {
                    s.termination = termination;
                    if (!quick
                            ? fetch == Fetch::hardware
                            : fetch == Fetch::hardware && step == 0.5 && termination == kDisplayTermination)
                        plan.add(s, "termination");
                }
            }
    };
    // Settings that change one thing come before fine steps: a quick run may not get to those.
    for (const double step : steps)
        if (step >= 0.5)
            addProduct(step);
    for (const double termination : {0.0, kFineTermination, kDisplayTermination}) {
        Setting s = asIs;
        s.termination = termination;
        plan.add(s, "termination");
    }
    for (const int share : quick ? std::vector<int>{4} : std::vector<int>{2, 4, 16, 64}) {
        Setting s = asIs;
        s.detail.memoryShare = share;
        plan.add(s, "memory");
        if (share != 4)
            continue;
        for (const EdgeFunction edges :
             {EdgeFunction::nearest, EdgeFunction::minimum, EdgeFunction::maximum, EdgeFunction::split}) {
            s.detail.edgeFunction = edges;
            if (!quick || edges == EdgeFunction::maximum)
                plan.add(s, "edges");
        }
    }
    Setting finest = asIs;
    finest.detail.finest = true;
    finest.detail.maxError.reset();
    plan.add(finest, "levels");
    for (const double maxError : quick ? std::vector<double>{2} : std::vector<double>{0.5, 2, 8}) {
        Setting s = asIs;
        s.detail.maxError = maxError;
        plan.add(s, "levels");
    }
    if (asIs.gradient)
        for (const Gradient gradient :
             {Gradient::forward, Gradient::central, Gradient::sobel, Gradient::analytic,
              Gradient::centralHalf, Gradient::cubic, Gradient::sobel2, Gradient::sobel4}) {
            Setting s = asIs;
            s.gradient = gradient;
            plan.add(s, "gradient");
        }
    for (const double step : steps)
        if (step < 0.5)
            addProduct(step);
    return plan.take();
}

std::string fractionText(double number) {
    if (number == 0)
        return "off";
    const double inverse = 1 / number;
    if (number < 1 && inverse <= 1024 && std::abs(inverse - std::round(inverse)) < 1e-9 * inverse)
        return "1/" + formatNumber(std::round(inverse));
    return formatNumber(number);
}

std::string methodName(const Setting& setting) {
    return integratorNames()[static_cast<std::size_t>(setting.integrator)] + ", " +
           fetchNames()[static_cast<std::size_t>(setting.fetch)];
}

std::string settingName(const Setting& s) {
    std::string text = methodName(s) + ", step " + fractionText(s.stepVoxels) + ", termination " +
                       fractionText(s.termination);
    if (s.gradient)
        text += ", " + gradientNames()[static_cast<std::size_t>(*s.gradient)] + " gradient";
    if (!s.detail.finest && !s.detail.maxError && s.detail.memoryShare == 1)
        text += ", chosen levels";
    if (s.detail.memoryShare != 1)
        text += ", memory 1/" + std::to_string(s.detail.memoryShare);
    if (s.detail.maxError)
        text += ", levels " + formatNumber(*s.detail.maxError);
    if (s.detail.edgeFunction != Quality{}.edgeFunction)
        text += ", " + edgeFunctionNames()[static_cast<std::size_t>(s.detail.edgeFunction)] + " edges";
    return text;
}

} // namespace tessera::accuracy
