// viewer/window/window_files.cpp: what a window opens and saves: volumes, pictures, scenes, presets. See
// window_state.h.
#include "viewer/window/window_state.h"

#include "core/base/names.h"
#include "core/base/output_file.h"
#include "viewer/annotations/shown_plane.h"
#include "viewer/session/file_kind.h"
#include "viewer/window/beside.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace tessera {
namespace {

std::string functionText(const TransferFunction& function) {
    Scene alone;
    alone.volumes = {{"v", function}};
    return sceneJson(alone);
}

} // namespace

void WindowState::open(const std::filesystem::path& path, const VolumePick& pick) {
    showBrowser = false;
    if (volume_ && pick == VolumePick{} && meansMesh(path)) {
        addMesh(path);
        return;
    }
    viewing_.open(path, wantedSize_.x > 0 ? wantedSize_ : Scene().imageSize, pick);
    state_ = viewing_.state(); // the previous state does not answer this request
    offers_.reset();
}

void WindowState::choose(std::size_t offer, int phase) {
    if (!offers_ || offer >= offers_->offers.size())
        return;
    const VolumeOffer chosen = offers_->offers[offer];
    VolumePick pick = chosen.pick;
    pick.phase = phase;
    open(chosen.path, pick);
}

void WindowState::showPhase(int phase) {
    if (!volume_ || phase < 1 || static_cast<std::size_t>(phase) > volume_->phases.size())
        return;
    phaseAsked_ = phase;
    VolumePick pick;
    pick.phase = phase;
    pick.inSameView = true;
    viewing_.open(volume_->path, wantedSize_.x > 0 ? wantedSize_ : scene_.imageSize, pick);
    state_ = viewing_.state();
    offers_.reset();
}

void WindowState::stepPhase(int by) {
    if (!volume_ || volume_->phases.empty())
        return;
    const auto count = static_cast<int>(volume_->phases.size());
    const int from =
        state_.kind == ViewingState::Kind::opening && phaseAsked_ > 0 ? phaseAsked_ : volume_->phase;
    showPhase((from - 1 + by % count + count) % count + 1);
}

/// @param write  gets the file's name and returns what to tell
template <typename Write>
void WindowState::save(const std::string& name, const char* extension, const Write& write) {
    if (!volume_)
        return;
    std::filesystem::path named = name.empty() ? volume_->path.stem() : std::filesystem::path(name);
    const std::string ending = named.extension().string();
    const bool hasEnding =
        !name.empty() &&
        (ending == extension || (extension == std::string(".png") && (ending == ".exr" || ending == ".tif")));
    const std::string stem = hasEnding ? (named.parent_path() / named.stem()).string() : named.string();
    std::filesystem::path file = stem + (hasEnding ? ending : extension);
    std::error_code ignored;
    for (int n = 2; std::filesystem::exists(file, ignored); ++n)
        file = stem + "-" + std::to_string(n) + (hasEnding ? ending : extension);
    trying([&] { tell(write(file) + std::filesystem::absolute(file, ignored).string()); });
}

std::vector<LegendBar> WindowState::legend() const {
    return volume_ ? colourLegend(scene_, volume_->volumes) : std::vector<LegendBar>();
}

Annotations WindowState::wordsOf(const VolumeSeen* volume) const {
    Annotations annotations = scene_.annotations;
    if (const std::string phase = volume ? volume->phaseLabel() : ""; !phase.empty())
        annotations.namePhase(phase);
    return annotations;
}

PictureMarks WindowState::marks() const {
    PictureMarks marks;
    marks.annotations = wordsOf(volume_.get());
    marks.annotations.scaleBar |= savesScaleBar;
    marks.annotations.legend |= savesLegend;
    if (marks.annotations.legend)
        marks.legend = legend();
    if (marks.annotations.labelLegend && volume_ && volume_->labels)
        marks.labels = legendLabels(*volume_->labels, scene_.volumes.front().labels);
    marks.measurements = scene_.measurements;
    marks.orientationKnown = volume_ && volume_->info.orientationKnown;
    if (volume_ && scene_.mode == Mode::slice)
        marks.plane = planeOf(scene_.slice, volume_->info);
    if (marks.annotations.error)
        marks.error = "measured error: not measured";
    return marks;
}

FigurePart WindowState::overlay() const {
    FigurePart part;
    part.annotations = wordsOf(volume_.get());
    Directions& directions = part.annotations.directions;
    directions = directions == Directions::letters || directions == Directions::all ? Directions::all
                                                                                    : Directions::cube;
    part.annotations.scaleBar = true;
    part.annotations.legend = showsLegend();
    part.annotations.measurements = false; // the tools draw them
    part.camera = camera();
    part.orientationKnown = volume_ && volume_->info.orientationKnown;
    if (part.annotations.legend)
        part.legend = legend();
    if (part.annotations.labelLegend && volume_ && volume_->labels)
        part.labels = legendLabels(*volume_->labels, scene_.volumes.front().labels);
    part.error =
        state_.measured.empty() ? "measured error: not measured yet" : "measured error: " + state_.measured;
    return part;
}

void WindowState::savePicture(const std::string& name, int times) {
    save(name, ".png", [&](const std::filesystem::path& file) {
        if (times == 1) {
            writeShown(file);
            return std::string("wrote the picture ");
        }
        writeStill(std::filesystem::absolute(file), times);
        return std::to_string(times * scene_.imageSize.x) + " x " +
               std::to_string(times * scene_.imageSize.y) + " pixels are drawn for ";
    });
}

void WindowState::writeShown(const std::filesystem::path& file) {
    std::vector<SavedPanel> panels;
    if (beside_ && beside_->volume())
        if (auto picture = beside_->viewing().picture())
            panels.push_back({std::move(picture), beside_->marks(*this)});
    viewing_.saveScreenshot(file, marks(), panels);
}

void WindowState::writeStill(const std::filesystem::path& file, int times) {
    Scene larger = scene_;
    larger.imageSize *= times;
    state_.atRest = false; // the last state does not know of it
    if (!beside_ || !beside_->volume())
        return viewing_.saveStill(larger, file, marks());
    Scene other = beside_->sceneNow(*this);
    other.imageSize = larger.imageSize;
    const auto figure = std::make_shared<FigureOfStills>(2);
    viewing_.saveStill(larger, file, marks(), {figure, 0});
    beside_->saveStill(other, file, beside_->marks(*this), {figure, 1});
}

void WindowState::saveScene(const std::string& name) {
    save(name, ".json", [&](const std::filesystem::path& file) {
        writeOutputFile(file, sceneJson(asStill(scene_)) + "\n");
        return std::string("wrote the scene ");
    });
}

void WindowState::takePreset(const std::string& nameOrFile) {
    const auto names = presetNames();
    if (std::find(names.begin(), names.end(), nameOrFile) != names.end()) {
        Scene scene = scene_;
        applyBuiltInPreset(nameOrFile, presetFunction(nameOrFile, volume_->values), scene);
        beginEdit();
        setScene(scene, false, true);
        return;
    }
    std::vector<std::string> leftOut;
    const Preset found = forValues(presets_.find(nameOrFile, leftOut), volume_->values);
    Scene scene = scene_;
    applyPreset(found, scene);
    beginEdit();
    setScene(scene, false, true);
    taken_ = found.name.empty() ? nameOrFile : found.name;
    takenText_ = functionText(function());
    presetName_.clear();
    if (!leftOut.empty())
        tell(found.name + ": left out: " + joinNames(leftOut));
}

const std::string& WindowState::presetName() {
    if (presetOf_ == asked_ && !presetName_.empty())
        return presetName_;
    presetOf_ = asked_;
    presetName_ = "its own";
    const std::string text = functionText(function());
    if (text == takenText_)
        presetName_ = taken_;
    for (const std::string& name : presetNames())
        try {
            if (functionText(presetFunction(name, volume_->values)) == text)
                presetName_ = name;
        } catch (const InputError&) { // a preset for other values
        }
    return presetName_;
}

void WindowState::keepPreset(const std::string& name) {
    presets_.keep(presetOf(scene_, name));
    tell("kept the preset " + name);
}

void WindowState::writePreset(const std::filesystem::path& file, const std::string& format) {
    const auto leftOut = presets_.write(presetOf(scene_, file.stem().string()), file, format);
    std::error_code ignored;
    tell("wrote " + std::filesystem::absolute(file, ignored).string() +
         (leftOut.empty() ? "" : "; left out: " + joinNames(leftOut)));
}

} // namespace tessera
