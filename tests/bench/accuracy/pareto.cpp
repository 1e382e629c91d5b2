// tests/bench/accuracy/pareto.cpp: see pareto.h.
#include "tests/bench/accuracy/pareto.h"

#include <algorithm>
#include <cmath>

namespace tessera::accuracy {

const std::vector<double>& errorTargets() {
    static const std::vector<double> targets = {1e-1, 1e-2, kDisplayError, 1e-3, 1e-4, 1e-5};
    return targets;
}

bool isPlain(const Sweep& sweep, const Setting& setting) {
    return setting.detail == Detail{} && setting.gradient == settingOf(sweep.scene.scene).gradient;
}

std::map<std::string, std::vector<WorkPoint>> envelopes(const Sweep& sweep,
                                                        const std::vector<PeerPoint>& peers) {
    std::map<std::string, std::vector<WorkPoint>> points;
    for (std::size_t i = 0; i < sweep.measured.size(); ++i) {
        const Measured& m = sweep.measured[i];
        const Setting& s = m.planned.setting;
        if (isPlain(sweep, s) && s.integrator != Integrator::automatic && m.leastMs() > 0)
            points[methodName(s)].push_back({m.error.rmse, m.leastMs(), i});
    }
    for (const PeerPoint& p : peers)
        if (p.scene == sweep.scene.name)
            points[p.renderer].push_back({p.rmse, p.ms, sweep.measured.size()});
    for (auto& [method, list] : points)
        list = paretoEnvelope(std::move(list));
    return points;
}

const Measured* paretoChoice(const Sweep& sweep) {
    const Measured* best = nullptr;
    for (const Measured& m : sweep.measured)
        if (isPlain(sweep, m.planned.setting) && m.error.rmse <= kDisplayError && m.leastMs() > 0 &&
            (!best || m.leastMs() < best->leastMs()))
            best = &m;
    return best;
}

std::vector<CommonChoice> commonChoices(const std::vector<Sweep>& sweeps) {
    std::vector<const Sweep*> reached;
    for (const Sweep& sweep : sweeps)
        if (paretoChoice(sweep))
            reached.push_back(&sweep);
    std::vector<CommonChoice> choices;
    if (reached.empty())
        return choices;
    for (const Measured& candidate : reached.front()->measured) {
        if (!isPlain(*reached.front(), candidate.planned.setting))
            continue;
        double logs = 0;
        bool everywhere = true;
        for (const Sweep* sweep : reached) {
            Setting s = candidate.planned.setting;
            s.gradient = settingOf(sweep->scene.scene).gradient;
            const Measured* m = sweep->find(s);
            everywhere = everywhere && m && m->error.rmse <= kDisplayError && m->leastMs() > 0;
            if (!everywhere)
                break;
            logs += std::log(m->leastMs() / paretoChoice(*sweep)->leastMs());
        }
        if (everywhere)
            choices.push_back(
                {candidate.planned.setting, std::exp(logs / static_cast<double>(reached.size()))});
    }
    std::sort(choices.begin(), choices.end(),
              [](const CommonChoice& a, const CommonChoice& b) { return a.slowdown < b.slowdown; });
    return choices;
}

} // namespace tessera::accuracy
