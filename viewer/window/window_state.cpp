// viewer/window/window_state.cpp: see desk.h.
#include "viewer/window/window_state.h"

#include "core/base/names.h"
#include "core/base/output_file.h"
#include "core/base/shown_text.h"
#include "viewer/session/file_kind.h"
#include "viewer/session/view_geometry.h"
#include "viewer/window/beside.h"
#include "viewer/window/function_edits.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

using namespace std::chrono_literals;
constexpr auto kRestAfter = 180ms; // without input, nothing moves any more
constexpr auto kSizeStays = 200ms; // before a picture gets another size
constexpr std::size_t kMostTimes = 200;

std::string functionText(const TransferFunction& function) {
    Scene alone;
    alone.volumes = {{"v", function}};
    return sceneJson(alone);
}

} // namespace

void Latency::drew(double ms, WindowClock::time_point now) {
    lastMs = ms;
    recentMs.push_back(ms);
    if (recentMs.size() > kMostTimes)
        recentMs.pop_front();
    pictureTimes.push_back(now);
}

double Latency::percentileMs(double share) const {
    if (recentMs.empty())
        return 0;
    std::vector<double> sorted(recentMs.begin(), recentMs.end());
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

double Latency::picturesPerSecond(WindowClock::time_point now) const {
    const auto recent = std::count_if(pictureTimes.begin(), pictureTimes.end(),
                                      [&](WindowClock::time_point t) { return now - t < 1s; });
    return static_cast<double>(recent);
}

void WindowState::update() {
    const auto now = WindowClock::now();
    if (auto volume = viewing_.volume(); volume != volume_) {
        const bool same = volume_ && volume && volume->path == volume_->path; // labels came beside it
        const bool isPhase = same && volume->phase != volume_->phase && volume->phases == volume_->phases;
        volume_ = std::move(volume);
        picture_.reset();
        picked_.reset();
        history_ = {};
        meshAdded_.clear();
        discs_.clear();
        discAsked_.reset();
        presetName_.clear();
        if (isPhase) {
            takePhase();
        } else if (volume_) {
            scene_ = volume_->scene;
            fitted_ = volume_->fitted;
            fitAsked_ = 0;
            held_ = fitted_ ? std::nullopt : std::optional<Held>({camera(), scene_.imageSize});
            settings_.opened(volume_->path);
            const VolumeInfo& info = volume_->info;
            slices_ = {};
            slices_.placeMm =
                glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
            slices_.window = windowOf(std::string("auto"), volume_->values);
            std::string remarks; // facts that affect interpretation; the State panel keeps them
            for (const std::string& remark : info.remarks)
                remarks += (remarks.empty() ? "" : "\n") + remark;
            if (!remarks.empty())
                tell(remarks);
            if (!volume_->eitherFile.empty())
                tell(volume_->eitherFile.filename().string() +
                     " has whole numbers on the lattice of the open volume, and is taken as its labels; the "
                     "panel Labels opens it as a volume");
            if (same && volume_->labels) // a scene without them may have been asked for meanwhile
                send(false);
        }
    }
    if (auto picture = viewing_.picture(); picture != picture_ && volume_) {
        picture_ = std::move(picture);
        if (picture_ && picture_->asked >= asked_ && askedAt_ != WindowClock::time_point()) {
            latency_.drew(std::chrono::duration<double, std::milli>(now - askedAt_).count(), now);
            askedAt_ = {};
        } else if (picture_) {
            latency_.pictureTimes.push_back(now);
        }
        while (latency_.pictureTimes.size() > kMostTimes)
            latency_.pictureTimes.pop_front();
        takeFitted();
    }
    offers_ = viewing_.offers();
    takeDiscValues();
    picked_ = viewing_.picked();
    if (picked_ && picked_->number <= pickedBefore_)
        picked_.reset();
    viewing_.showLevels(showLevels);
    state_ = viewing_.state();
    if (!state_.problem.empty()) {
        lastProblem_ = state_.problem;
        tell(state_.problem, true);
        viewing_.problemSeen();
    }
    settleMesh();
    if (const std::string notice = viewing_.takeNotice(); !notice.empty())
        tell(notice);
    if (message_ && now > message_->until)
        message_.reset();
}

/// The volume is that of another phase: the scene names it.
void WindowState::takePhase() {
    const Scene& opened = volume_->scene;
    for (std::size_t n = 0; n < std::min(scene_.volumes.size(), opened.volumes.size()); ++n)
        scene_.volumes[n].source = opened.volumes[n].source;
    scene_.volumes.front().labels.store = opened.volumes.front().labels.store;
    send(false);
    viewing_.showSlices(slices_); // the planes of the phase before are gone
}

/// Takes the fitted camera from the picture that answers the request.
void WindowState::takeFitted() {
    if (fitAsked_ == 0 || !picture_ || picture_->asked < fitAsked_)
        return;
    scene_.camera = picture_->camera;
    fitAsked_ = 0;
}

std::uint64_t WindowState::ask(bool moving) {
    if (fitAsked_ == 0)
        return viewing_.show(scene_, moving);
    Scene wish = scene_;
    wish.camera = *fitted_;
    return fitAsked_ = viewing_.show(wish, moving);
}

void WindowState::send(bool moving, bool fit) {
    if (!volume_)
        return;
    lastInput_ = WindowClock::now();
    if (askedAt_ == WindowClock::time_point())
        askedAt_ = lastInput_; // time of the first input without a picture
    if (fit && fitted_)
        fitAsked_ = ~std::uint64_t{0}; // until ask() returns its number
    asked_ = ask(moving);
    if (picked_)
        pickedBefore_ = picked_->number;
    picked_.reset();
    owesRest_ = moving;
}

void WindowState::setScene(const Scene& scene, bool moving, bool fit) {
    const Scene before = scene_;
    scene_ = scene;
    scene_.imageSize = before.imageSize;
    showSomething(before);
    const bool slices = scene_.mode == Mode::slice;
    const bool another = scene_.mode != before.mode;
    if (std::get<Camera>(scene.camera) != std::get<Camera>(before.camera)) { // along a path
        fitted_.reset();
        held_.reset();
        fitAsked_ = 0;
    } else if (slices && (another || scene_.slice.orientation != before.slice.orientation ||
                          scene_.slice.normal != before.slice.normal)) {
        fitted_ = FittedView{}; // a plane is looked at along its normal
        held_.reset();
        fit = true;
    } else if (another && before.mode == Mode::slice) {
        fitted_ = volume_->fitted.value_or(FittedView{});
        held_.reset();
    }
    send(moving, fit || another || scene_.surfaces.size() != before.surfaces.size());
}

/// Isosurfaces alone are a picture only where there is one.
void WindowState::showSomething(const Scene& before) {
    if (scene_.mode != Mode::isosurface || !scene_.surfaces.empty())
        return;
    if (before.mode == Mode::isosurface) { // the last was taken away
        scene_.mode = Mode::composite;
        tell("without an isosurface the mode is composite");
        return;
    }
    scene_.surfaces.push_back(surfaceOffered());
    tell("an isosurface at " + valueText(scene_.surfaces.back().value, volume_->info.unit) +
         ", at half the function's largest opacity; the panel Mode changes it");
}

Isosurface WindowState::surfaceOffered() const {
    const double value =
        std::round(halfOpaqueValue(function(), volume_->values.lowest, volume_->values.highest));
    return {value, function().colour(value), 1};
}

void WindowState::setCamera(const Camera& camera, bool moving) {
    fitted_.reset();
    fitAsked_ = 0;
    scene_.camera = camera;
    held_ = {camera, scene_.imageSize};
    send(moving);
}

void WindowState::fitView(View side) {
    if (!volume_)
        return;
    if (scene_.mode == Mode::slice) {
        Scene turned = scene_;
        turned.slice.orientation = side == View::left || side == View::right           ? Orientation::sagittal
                                   : side == View::anterior || side == View::posterior ? Orientation::coronal
                                                                                       : Orientation::axial;
        turned.slice.positionMm.reset();
        beginEdit();
        setScene(turned, false, true);
        return;
    }
    fitted_ = FittedView{side, camera().projection, fitKind(), true, {}};
    held_.reset();
    scene_.camera = seenFrom(camera(), side); // until it is known better
    send(false, true);
}

void WindowState::fitView() {
    if (!volume_)
        return;
    if (scene_.mode == Mode::slice) {
        fitted_ = FittedView{};
    } else if (!fitted_) {
        const glm::dmat3 axes = patientFromCamera(camera());
        fitted_ = FittedView{View::anterior, camera().projection, fitKind(), true,
                             ViewAxes{axes[0], axes[1], axes[2]}};
    }
    held_.reset();
    send(false, true);
}

void WindowState::setProjection(Projection projection) {
    if (!volume_ || projection == camera().projection)
        return;
    const Camera projected = projectedBy(camera(), projection);
    if (!fitted_ || scene_.mode == Mode::slice) {
        setCamera(projected, false);
        return;
    }
    fitted_->projection = projection;
    fitted_->named = true;
    scene_.camera = projected; // until it is known better
    send(false, true);
}

Fit WindowState::fitKind() const {
    return volume_->fitted ? volume_->fitted->fit : Fit::shown;
}

void WindowState::setFunction(const TransferFunction& function, bool moving) {
    scene_.volumes.front().transferFunction = function;
    send(moving);
}

void WindowState::setLabels(const Labels& labels, bool moving) {
    scene_.volumes.front().labels = labels;
    send(moving);
}

void WindowState::addMesh(const std::filesystem::path& file) {
    const std::string name = file.filename().string();
    const std::filesystem::path path = std::filesystem::absolute(file).lexically_normal();
    Scene scene = scene_;
    for (const SceneMesh& mesh : scene.meshes)
        if (mesh.path == path)
            return tell(name + " is a mesh of the scene already");
    if (scene.meshes.size() == SceneMesh::kMost)
        return tell("a scene has at most " + std::to_string(SceneMesh::kMost) + " meshes", true);
    scene.meshes.push_back({path});
    beginEdit();
    setScene(scene, false, true);
    meshAdded_ = path;
    meshAsked_ = asked_;
    tell(name + " is a mesh of the scene; the panel Meshes has its look, Ctrl Z takes it away" +
         (reductionOf(scene) == Reduction::composite ? "" : "; mode " + nameOf(scene.mode) + " draws none"));
}

/// A mesh that cannot be read leaves the scene as it was before.
void WindowState::settleMesh() {
    if (meshAdded_.empty() || (!isRefused() && !isAnswered()))
        return;
    const std::filesystem::path path = std::exchange(meshAdded_, {});
    if (!isRefused())
        return;
    if (asked_ == meshAsked_)
        history_.drop();
    Scene scene = scene_;
    std::erase_if(scene.meshes, [&](const SceneMesh& mesh) { return mesh.path == path; });
    setScene(scene, false, true);
}

void WindowState::setPictureSize(const glm::ivec2& size) {
    if (size == wantedSize_)
        return;
    wantedSize_ = size;
    sizeChanged_ = WindowClock::now();
}

bool WindowState::settle() {
    const auto now = WindowClock::now();
    if (volume_ && wantedSize_.x > 0 && wantedSize_ != scene_.imageSize) {
        if (now - sizeChanged_ < kSizeStays)
            return true;
        scene_.imageSize = wantedSize_;
        if (held_)
            scene_.camera = heldBy(held_->camera, held_->size, wantedSize_);
        send(false, true);
    }
    if (owesRest_ && now - lastInput_ >= kRestAfter) {
        owesRest_ = false;
        asked_ = ask(false);
    }
    return owesRest_ || message_;
}

void WindowState::setSlices(const SliceWish& wish) {
    slices_ = wish;
    viewing_.showSlices(wish);
}

/// Undo and redo keep the current camera.
void WindowState::takeBack(Scene scene) {
    scene.camera = scene_.camera;
    setScene(scene, false);
}

void WindowState::undo() {
    if (history_.canUndo())
        takeBack(history_.undo(scene_));
}

void WindowState::redo() {
    if (history_.canRedo())
        takeBack(history_.redo(scene_));
}

void WindowState::resetCamera() {
    if (!volume_)
        return;
    if (!volume_->fitted) {
        const Scene& opened = volume_->scene;
        setCamera(heldBy(std::get<Camera>(opened.camera), opened.imageSize, scene_.imageSize), false);
        return;
    }
    scene_.camera = volume_->scene.camera; // until it is known better
    fitted_ = scene_.mode == Mode::slice ? FittedView{} : *volume_->fitted;
    held_.reset();
    send(false, true);
}

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

PictureMarks WindowState::marks() const {
    PictureMarks marks;
    marks.annotations = scene_.annotations;
    marks.annotations.scaleBar |= savesScaleBar;
    marks.annotations.legend |= savesLegend;
    if (marks.annotations.legend)
        marks.legend = legend();
    if (marks.annotations.labelLegend && volume_ && volume_->labels)
        marks.labels = legendLabels(*volume_->labels, scene_.volumes.front().labels);
    marks.measurements = scene_.measurements;
    marks.orientationKnown = volume_ && volume_->info.orientationKnown;
    if (marks.annotations.error)
        marks.error = "measured error: not measured";
    return marks;
}

FigurePart WindowState::overlay() const {
    FigurePart part;
    part.annotations = scene_.annotations;
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
    if (!beside_ || !beside_->volume())
        return viewing_.saveStill(larger, file, marks());
    Scene other = beside_->sceneNow(*this);
    other.imageSize = larger.imageSize;
    const auto figure = std::make_shared<FigureOfStills>(2);
    viewing_.saveStill(larger, file, marks(), {figure, 0});
    beside_->viewing().saveStill(other, file, beside_->marks(*this), {figure, 1});
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

/// Answers come in the order of questions.
void WindowState::takeDiscValues() {
    if (!discAsked_)
        return;
    const auto values = viewing_.discValues();
    if (!values || values->number < discNumber_)
        return;
    constexpr std::size_t kMostKept = 64;
    if (discs_.size() >= kMostKept)
        discs_.erase(discs_.begin());
    discs_.emplace_back(*std::exchange(discAsked_, {}), *values);
}

std::string WindowState::describe(const Measurement& m) {
    std::string words = tessera::describe(m);
    if (m.kind != MeasurementKind::circle || !std::isfinite(valueOf(m)))
        return words;
    const auto known =
        std::find_if(discs_.begin(), discs_.end(), [&](const auto& disc) { return disc.first == m; });
    if (known == discs_.end()) {
        if (!discAsked_) {
            discAsked_ = m;
            discNumber_ = viewing_.askValues(m);
        }
        return words;
    }
    const std::string values = discText(known->second, volume_->info.unit);
    return values.empty() ? words : words + "\n" + values;
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

void WindowState::tell(const std::string& text, bool problem) {
    message_ = Message{text, problem, WindowClock::now() + (problem ? 12s : 4s)};
}

} // namespace tessera
