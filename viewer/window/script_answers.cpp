// viewer/window/script_answers.cpp: the part of script.h that prints, and the steps on two scans.
#include "core/base/shown_text.h"
#include "viewer/window/beside.h"
#include "viewer/window/label_panel.h"
#include "viewer/window/script.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>

namespace tessera {
namespace {

/// Of the program, as the system counts it; 0 where it does not say.
std::size_t residentKib() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind("VmRSS:", 0) == 0)
            return static_cast<std::size_t>(std::strtoull(line.c_str() + 6, nullptr, 10));
    return 0;
}

/// The place of the planes' crosshair, and the value there.
std::string crosshairText(const std::string& name, const VolumeSeen& volume, const Viewing& viewing) {
    const auto shown = viewing.slices();
    if (!shown)
        return name + ": no planes";
    const glm::dvec3& mm = shown->wish.placeMm;
    char place[96];
    std::snprintf(place, sizeof place, " at %.3f %.3f %.3f mm", mm.x, mm.y, mm.z);
    return name + ": " +
           (std::isfinite(shown->value) ? valueText(shown->value, volume.info.unit) : "nothing") + place;
}

} // namespace

/// How two scans are linked.
void Script::takeLink(const Step& step, WindowState& desk) {
    if (!desk.beside())
        refuse(step, "a second scan (--beside)");
    const std::string &what = step.words[1], &how = step.words[2];
    BesideLinks links = desk.beside()->links();
    using Places = BesideLinks::Places;
    if (what == "places" && (how == "coordinates" || how == "middles"))
        links.places = how == "middles" ? Places::middles : Places::coordinates;
    else if (what == "places" && how == "auto")
        links.places.reset();
    else if (what == "look" && (how == "on" || how == "off"))
        links.look = how == "on";
    else if (what == "cuts" && (how == "on" || how == "off"))
        links.cuts = how == "on";
    else
        refuse(step, "link places coordinates, middles or auto, link look on or off, link cuts on or off");
    desk.beside()->setLinks(links);
}

/// Returns whether the answer is there.
bool Script::takePick(const Step& step, WindowState& desk) {
    const bool isBeside = step.words.size() > 3 && step.words[3] == "beside";
    if (isBeside && (!desk.beside() || !desk.beside()->volume()))
        refuse(step, "a second scan (--beside)");
    if (question_ == 0)
        question_ =
            (isBeside ? desk.beside()->viewing() : desk.viewing()).pick({number(step, 1), number(step, 2)});
    const auto& picked = isBeside ? desk.beside()->picked() : desk.picked();
    if (!picked || picked->number < question_)
        return false;
    question_ = 0;
    const std::string names = isBeside ? "" : labelNames(*desk.volume(), *picked);
    const std::string ofLabels = names.empty() ? "" : ", " + names;
    if (picked->hit && !picked->mesh.empty())
        std::printf("picked %s at %.3f %.3f %.3f mm\n", picked->mesh.c_str(), picked->mm.x, picked->mm.y,
                    picked->mm.z);
    else if (picked->hit)
        std::printf("picked %.6g at %.3f %.3f %.3f mm, level %d%s\n", picked->value, picked->mm.x,
                    picked->mm.y, picked->mm.z, picked->level, ofLabels.c_str());
    else
        std::printf("picked nothing\n");
    std::fflush(stdout);
    return true;
}

void Script::print(const Step& step, WindowState& desk, const Window& window) {
    const std::string& what = step.words[1];
    const ViewingState& s = desk.state();
    if (what == "latency") {
        const Latency& l = desk.latency();
        std::printf("latency of %zu pictures: median %.1f ms, 95th percentile %.1f ms, most %.1f ms\n",
                    l.recentMs.size(), l.percentileMs(0.5), l.percentileMs(0.95), l.percentileMs(1));
        if (const ShownPicture* const p = desk.picture())
            std::printf("last picture: %d x %d in %.1f ms\n", p->image.size.x, p->image.size.y, p->drawingMs);
    } else if (what == "samples") {
        const ShownPicture* const p = desk.picture();
        const SamplesSeen seen = p ? p->samples.value_or(SamplesSeen()) : SamplesSeen();
        std::printf("samples %d of %d, noise %.4g, %.0f ms\n", seen.taken, seen.asked, seen.noise.value_or(0),
                    p ? p->drawingMs : 0);
    } else if (what == "message") {
        std::printf("message: %s\n", desk.message() ? desk.message()->text.c_str() : "");
    } else if (what == "beside") {
        std::printf("beside: %s\n", desk.beside() ? desk.beside()->about(desk).c_str() : "none");
    } else if (what == "planes") {
        std::printf("%s\n", crosshairText("planes", *desk.volume(), desk.viewing()).c_str());
        if (Beside* const beside = desk.beside(); beside && beside->volume())
            std::printf("%s\n", crosshairText("beside", *beside->volume(), beside->viewing()).c_str());
    } else if (what == "memory") {
        std::printf("pictures %llu, resident %zu KiB, GL objects %d\n",
                    static_cast<unsigned long long>(s.pictures), residentKib(), window.countGlObjects());
    } else {
        std::printf("pictures %llu, RAM %zu, GPU %zu, bricks %zu of %zu, levels %d to %d, moves left "
                    "%zu, at rest %d\n",
                    static_cast<unsigned long long>(s.pictures), s.ramUsed, s.gpuUsed, s.bricksAsWanted,
                    s.bricksShown, s.finestLevel, std::max(s.finestLevel, s.coarsestLevel), s.movesLeft,
                    s.atRest ? 1 : 0);
    }
}

} // namespace tessera
