// viewer/window/window_state.cpp: see window_state.h. What it opens and saves: window_files.cpp.
#include "viewer/window/window_state.h"

#include "core/base/names.h"
#include "viewer/session/view_geometry.h"
#include "viewer/window/function_edits.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

using namespace std::chrono_literals;
constexpr auto kRestAfter = 180ms; // without input, nothing moves any more
constexpr auto kSizeStays = 200ms; // before a picture gets another size
constexpr std::size_t kMostTimes = 200;

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
            slices_.window = windowOf(std::string("auto"), volume_->values, Mode::slice);
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
    const double value = std::round(halfOpaqueValue(function(), volume_->lowest(), volume_->highest()));
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

void WindowState::tell(const std::string& text, bool problem) {
    message_ = Message{text, problem, WindowClock::now() + (problem ? 12s : 4s)};
}

} // namespace tessera
