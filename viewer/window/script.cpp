// viewer/window/script.cpp: see script.h.
#include "viewer/window/script.h"

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/output_file.h"
#include "core/scene/preset.h"
#include "core/scene/scene_presets.h"
#include "viewer/session/view_geometry.h"
#include "viewer/window/beside.h"
#include "viewer/window/function_edits.h"
#include "viewer/window/label_panel.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <glm/trigonometric.hpp>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

/// Keys with names, and their numbers as GLFW has them.
constexpr std::array<std::pair<std::string_view, int>, 11> kNamedKeys = {{{",", 44},
                                                                          {".", 46},
                                                                          {"Space", 32},
                                                                          {"Home", 268},
                                                                          {"Esc", 256},
                                                                          {"Tab", 258},
                                                                          {"Enter", 257},
                                                                          {"Left", 263},
                                                                          {"Right", 262},
                                                                          {"Up", 265},
                                                                          {"Down", 264}}};

/// Words that follow each step's name: at least.
const std::map<std::string, std::size_t>& wordsOfSteps() {
    static const std::map<std::string, std::size_t> words = {
        {"open", 1},         {"wait", 1},       {"orbit", 2},     {"pan", 2},          {"zoom", 1},
        {"roll", 1},         {"view", 1},       {"turn", 2},      {"preset", 1},       {"light", 1},
        {"shift", 2},        {"isosurface", 1}, {"size", 1},      {"pick", 2},         {"picture", 1},
        {"window", 1},       {"scene", 1},      {"panels", 1},    {"help", 1},         {"planes", 1},
        {"mode", 1},         {"window-of", 1},  {"crop", 6},      {"levels", 1},       {"place", 3},
        {"print", 1},        {"projection", 1}, {"quit", 0},      {"lose-context", 0}, {"keep-preset", 1},
        {"write-preset", 2}, {"line", 3},       {"tree", 3},      {"fly-to", 1},       {"fly", 1},
        {"record", 0},       {"load-path", 1},  {"save-path", 1}, {"cover", 0},        {"look-at-patch", 1},
        {"fit", 0},          {"choose", 1},     {"phase", 1},     {"click", 2},        {"double-click", 2},
        {"drag", 4},         {"wheel", 3},      {"key", 1},       {"answer", 1},       {"scale-bar", 1},
        {"legend", 1},       {"label", 1},      {"link", 2}};
    return words;
}

} // namespace

Script::Script(const std::filesystem::path& file) : file_(file) {
    refusePipeOrDevice(file);
    std::ifstream stream(file);
    if (!stream)
        throw badFile(file.string(), "a script", "a file that cannot be read");
    std::string line;
    for (int n = 1; std::getline(stream, line); ++n) {
        std::istringstream words(line);
        Step step{n, {}};
        for (std::string word; words >> word;)
            step.words.push_back(word);
        if (step.words.empty() || step.words.front().front() == '#')
            continue;
        const auto known = wordsOfSteps().find(step.words.front());
        if (known == wordsOfSteps().end())
            refuse(step, "a step (see the user guide)");
        if (step.words.size() - 1 < known->second)
            refuse(step, std::to_string(known->second) + " words after " + known->first);
        steps_.push_back(std::move(step));
    }
}

void Script::refuse(const Step& step, const std::string& expected) const {
    std::string found;
    for (const std::string& word : step.words)
        found += (found.empty() ? "" : " ") + word;
    throw badFile(file_.string() + ", line " + std::to_string(step.line), expected, "\"" + found + "\"");
}

double Script::number(const Step& step, std::size_t word) const {
    char* end = nullptr;
    const double value = std::strtod(step.words[word].c_str(), &end);
    if (*end != '\0' || !std::isfinite(value))
        refuse(step, "a number");
    return value;
}

bool Script::waits(const Step& step, WindowState& desk, const Endoscopy& endoscopy) {
    const std::string& what = step.words[1];
    const ViewingState& s = desk.state();
    const ShownPicture* const picture = desk.picture();
    const bool isTime = std::isdigit(static_cast<unsigned char>(what.front())) != 0;
    if (what == "choice")
        return s.kind == ViewingState::Kind::opening ||
               (!desk.offers() && s.kind != ViewingState::Kind::failed);
    if ((s.kind == ViewingState::Kind::failed || s.kind == ViewingState::Kind::choosing) && !isTime)
        refuse(step, "a volume, but: " + s.what);
    const bool settled = desk.hasAsked();
    const Beside* const beside = desk.beside();
    if (what == "volume")
        return !desk.volume() || (beside && !beside->volume() && !beside->atRest());
    if (what == "line")
        return endoscopy.isSearching();
    if (what == "picture")
        return !picture;
    if (desk.isRefused() && !isTime && what != "volume")
        refuse(step, "a scene that can be drawn, but: " + desk.lastProblem());
    if (what == "whole")
        return !settled || !desk.isAnswered() || picture->stage < Stage::whole;
    if (what == "samples" && step.words.size() < 3)
        refuse(step, "a number of samples");
    if (what == "samples")
        return !settled || !desk.isAnswered() || !picture->samples ||
               picture->samples->taken < number(step, 2);
    if (what == "still" || what == "rest") // the still comes last
        return !settled || !desk.isAnswered() || !s.atRest || (beside && !beside->atRest());
    return WindowClock::now() - began_ < std::chrono::duration<double, std::milli>(number(step, 1));
}

/// Opens it, and waits until it is there.
bool Script::takePhase(const Step& step, WindowState& desk) {
    constexpr int kLooks = 3; // the state may be there before the volume
    const double n = number(step, 1);
    const std::size_t count = desk.volume() ? desk.volume()->phases.size() : 0;
    if (!(n >= 1 && n <= static_cast<double>(count)))
        refuse(step, "the number of one of several phases of the volume");
    const auto phase = static_cast<int>(n);
    if (desk.volume()->phase == phase)
        return phaseLooks_ = 0, true;
    if (desk.state().kind == ViewingState::Kind::opening)
        return false;
    if (phaseLooks_++ == 0)
        desk.showPhase(phase);
    else if (phaseLooks_ > kLooks)
        refuse(step, "a phase that can be opened, but: " + desk.lastProblem());
    return false;
}

/// How a label shows, by its value.
void Script::takeLabel(const Step& step, WindowState& desk) {
    if (!desk.volume()->labels)
        refuse(step, "a volume with labels");
    const LabelList& list = *desk.volume()->labels;
    const std::string& how = step.words[1];
    Labels labels = withAllShown(desk.labels());
    if (how != "all") {
        if (step.words.size() < 3 || (how != "show" && how != "hide" && how != "only"))
            refuse(step, "label all, or show, hide or only and a value");
        const double value = number(step, 2);
        const auto known = value >= 0 && value <= std::numeric_limits<std::uint32_t>::max()
                               ? numberOf(list, static_cast<std::uint32_t>(value))
                               : std::nullopt;
        if (!known)
            refuse(step, "the value of a label");
        const std::size_t numbers[] = {*known};
        labels = how == "only" ? withAlone(list, desk.labels(), numbers)
                               : withShown(list, desk.labels(), numbers, how == "show");
    }
    desk.beginEdit();
    desk.setLabels(labels, false);
}

/// A step along a line.
/// @param taken  whether the step belongs to a line. Returns whether it is done.
bool Script::takeEndoscopy(const Step& step, WindowState& desk, Endoscopy& endoscopy, bool& taken) {
    const std::string& name = step.words.front();
    taken = true;
    if (name == "line" || name == "tree") {
        if ((step.words.size() - 1) % 3 != 0 || (name == "tree" && step.words.size() != 4))
            refuse(step, "places of three numbers, one of a tree");
        std::vector<glm::dvec3> places;
        for (std::size_t i = 1; i < step.words.size(); i += 3)
            places.push_back({number(step, i), number(step, i + 1), number(step, i + 2)});
        endoscopy.find(desk, places, name == "tree");
        return true;
    }
    if (name == "load-path")
        return endoscopy.load(desk, step.words[1]), true;
    const std::set<std::string> others = {"save-path", "fly-to",        "fly",   "record",
                                          "cover",     "look-at-patch", "answer"};
    if (!others.contains(name))
        return taken = false;
    if (!endoscopy.hasLine())
        refuse(step, "a line first (line, wait line)");
    if (name == "save-path")
        endoscopy.save(desk, step.words[1]);
    else if (name == "record")
        endoscopy.record(desk);
    else if (name == "cover")
        endoscopy.measureCoverage(desk, step.words.size() > 1 && step.words[1] == "both");
    else if (name == "look-at-patch")
        endoscopy.lookAtPatch(desk, static_cast<std::size_t>(std::max(1.0, number(step, 1))) - 1);
    else if (name == "answer") {
        using Answer = Endoscopy::Answer;
        if (!endoscopy.asks() ||
            (step.words[1] != "fly" && step.words[1] != "stop" && step.words[1] != "cancel"))
            refuse(step, "an answer to a question of the window: fly, stop or cancel");
        endoscopy.answer(desk, step.words[1] == "fly"    ? Answer::fly
                               : step.words[1] == "stop" ? Answer::stop
                                                         : Answer::cancel);
    } else if (name == "fly-to")
        endoscopy.flyTo(desk, number(step, 1));
    else {
        if (endoscopy.asks())
            refuse(step, "an answer first (answer fly, stop or cancel)");
        const int pictures = static_cast<int>(number(step, 1));
        if (turned_ > 0 && desk.state().pictures == pictures_)
            return false; // the previous step's picture is not finished
        if (turned_ >= pictures)
            return turned_ = 0, true;
        pictures_ = desk.state().pictures;
        endoscopy.flyTo(desk, endoscopy.lengthMm() * ++turned_ / std::max(1, pictures));
        return false;
    }
    return true;
}

/// One frame of a click or a drag. Returns whether it was the last.
bool Script::takeHand(const Step& step, const Window& window) {
    const bool drags = step.words.front() == "drag";
    const glm::dvec2 from(number(step, 1), number(step, 2)),
        to = drags ? glm::dvec2(number(step, 3), number(step, 4)) : from;
    constexpr int kWay = 6; // frames
    const ScriptedHand up{from, false, 0}, down{from, true, 0}, end{to, false, 0};
    std::vector<ScriptedHand> frames = {up, up, down};
    if (step.words.front() == "wheel")
        frames.back() = {from, false, number(step, 3)};
    for (int n = 1; drags && n <= kWay; ++n)
        frames.push_back({from + (to - from) * (static_cast<double>(n) / kWay), true, 0});
    if (step.words.front() == "double-click")
        frames.insert(frames.end(), {up, down});
    frames.insert(frames.end(), {end, end});
    window.point(frames[handed_++]);
    if (handed_ < frames.size())
        return false;
    handed_ = 0;
    return true;
}

bool Script::take(const Step& step, WindowState& desk, Endoscopy& endoscopy, const Window& window) {
    const std::string& name = step.words.front();
    const auto word = [&](std::size_t i) -> const std::string& { return step.words[i]; };
    if (name == "open")
        return desk.open(word(1)), true;
    if (name == "choose") {
        const auto offers = desk.offers();
        if (!offers && desk.state().kind == ViewingState::Kind::opening)
            return false;
        const double n = number(step, 1);
        if (!offers || !(n >= 1 && n <= static_cast<double>(offers->offers.size())))
            refuse(step, "the number of one of several volumes that are offered");
        return desk.choose(static_cast<std::size_t>(n) - 1,
                           step.words.size() > 2 ? static_cast<int>(number(step, 2)) : 0),
               true;
    }
    if (name == "phase")
        return takePhase(step, desk);
    if (name == "wait")
        return !waits(step, desk, endoscopy);
    if (name == "size") {
        int width = 0, height = 0;
        if (std::sscanf(word(1).c_str(), "%dx%d", &width, &height) != 2 || width < 64 || height < 64)
            refuse(step, "WIDTHxHEIGHT");
        return window.resize({width, height}), true;
    }
    if (name == "panels")
        return desk.showPanels = word(1) == "on", true;
    if (name == "help")
        return desk.showHelp = word(1) == "on", true;
    if (name == "scale-bar")
        return desk.savesScaleBar = word(1) == "on", true;
    if (name == "legend")
        return desk.showLegend = desk.savesLegend = word(1) == "on", true;
    if (name == "levels")
        return desk.showLevels = word(1) == "on", true;
    if (name == "planes")
        return desk.showSlices = word(1) == "on", true;
    if (name == "key") {
        const char letter = word(1).front();
        for (const auto& [key, code] : kNamedKeys)
            if (word(1) == key)
                return window.press(code, false), true;
        if (word(1).size() != 1 || !std::isalnum(static_cast<unsigned char>(letter)))
            refuse(step,
                   "a letter, a digit, or \",\", \".\", Space, Home, Esc, Tab, Enter, Left, Right, Up, Down");
        return window.press(std::toupper(static_cast<unsigned char>(letter)),
                            std::isupper(static_cast<unsigned char>(letter)) != 0),
               true;
    }
    if (name == "click" || name == "double-click" || name == "drag" || name == "wheel")
        return takeHand(step, window);
    if (name == "quit")
        return window.close(), true;
    if (name == "lose-context")
        return window.loseContext(), true;
    if (name == "window")
        return window.capture(word(1)), true;
    if (!desk.volume())
        refuse(step, "an open volume first (wait volume)");
    if (desk.isFitting())
        return false; // the next step needs the fitted camera
    bool alongALine = false;
    if (const bool done = takeEndoscopy(step, desk, endoscopy, alongALine); alongALine)
        return done;
    const Camera& camera = desk.camera();
    if (name == "orbit")
        desk.setCamera(orbited(camera, glm::radians(glm::dvec2(number(step, 1), number(step, 2)))), true);
    else if (name == "pan")
        desk.setCamera(panned(camera, {number(step, 1), number(step, 2)}), true);
    else if (name == "zoom")
        desk.setCamera(zoomed(camera, number(step, 1)), true);
    else if (name == "fit")
        desk.fitView();
    else if (name == "roll")
        desk.setCamera(rolled(camera, glm::radians(number(step, 1))), true);
    else if (name == "view")
        desk.fitView(parseName<View>(word(1), file_.string()));
    else if (name == "place") {
        SliceWish wish = desk.slices();
        wish.placeMm = {number(step, 1), number(step, 2), number(step, 3)};
        desk.setSlices(wish);
    } else if (name == "projection")
        desk.setProjection(word(1) == "parallel" ? Projection::parallel : Projection::perspective);
    else if (name == "turn") {
        const int frames = static_cast<int>(number(step, 2));
        if (turned_ > 0 && desk.state().pictures == pictures_)
            return false; // the previous step's picture is not finished
        if (turned_ >= frames)
            return turned_ = 0, true;
        pictures_ = desk.state().pictures;
        desk.setCamera(orbited(camera, {glm::radians(number(step, 1)) / std::max(1, frames), 0}), true);
        ++turned_;
        return false;
    } else if (name == "label") {
        takeLabel(step, desk);
    } else if (name == "preset") {
        desk.takePreset(word(1));
    } else if (name == "keep-preset") {
        desk.keepPreset(word(1));
    } else if (name == "write-preset") {
        desk.writePreset(word(2), word(1));
    } else if (name == "shift") {
        desk.setFunction(shiftedAndStretched(desk.function(), number(step, 1), number(step, 2)), true);
    } else if (name == "light" || name == "isosurface" || name == "mode" || name == "window-of" ||
               name == "crop") {
        Scene scene = desk.scene();
        if (name == "light")
            applyLook(word(1), scene);
        else if (name == "mode")
            scene.mode = parseName<Mode>(word(1), file_.string());
        else if (name == "window-of")
            scene.window = parseWindow(word(1), file_.string());
        else if (name == "crop")
            scene.cuts.boxes = {{{number(step, 1), number(step, 3), number(step, 5)},
                                 {number(step, 2), number(step, 4), number(step, 6)},
                                 CropBox::Space::patient,
                                 Keep::inside}};
        else
            scene.surfaces.push_back({number(step, 1), {1, 0.95, 0.85}, 1});
        desk.setScene(scene, false);
    } else if (name == "pick") {
        return takePick(step, desk);
    } else if (name == "picture") {
        if (step.words.size() < 3)
            desk.writeShown(word(1));
        else
            desk.writeStill(word(1), static_cast<int>(std::clamp(number(step, 2), 1.0, 64.0)));
    } else if (name == "link") {
        takeLink(step, desk);
    } else if (name == "scene") {
        writeOutputFile(word(1), sceneJson(asStill(desk.scene())) + "\n");
    } else if (name == "print") {
        print(step, desk, window);
    }
    std::fflush(stdout);
    return true;
}

bool Script::advance(WindowState& desk, Endoscopy& endoscopy, const Window& window) {
    while (next_ < steps_.size()) {
        if (!stepBegan_)
            began_ = WindowClock::now();
        stepBegan_ = true;
        if (!take(steps_[next_], desk, endoscopy, window))
            return true;
        stepBegan_ = false;
        ++next_;
        const std::string& taken = steps_[next_ - 1].words.front();
        if (taken == "window" || taken == "quit" || taken.ends_with("click") || taken == "drag" ||
            taken == "wheel" || taken == "key")
            return true; // after the next frame
    }
    return false;
}

} // namespace tessera
