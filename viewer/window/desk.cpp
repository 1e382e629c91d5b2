// viewer/window/desk.cpp: see desk.h.
#include "viewer/window/desk.h"

#include "core/nearest_name.h"
#include "core/output_file.h"

#include <algorithm>

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

void Desk::update() {
    const auto now = WindowClock::now();
    if (auto volume = viewing_.volume(); volume != volume_) {
        volume_ = std::move(volume);
        picture_.reset();
        picked_.reset();
        history_ = {};
        if (volume_) {
            scene_ = volume_->scene;
            settings_.opened(volume_->path);
            const VolumeInfo& info = volume_->info;
            slices_ = {};
            slices_.placeMm =
                glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
            slices_.window = windowOf(std::string("auto"), volume_->values);
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
    }
    picked_ = viewing_.picked();
    if (picked_ && picked_->number <= pickedBefore_)
        picked_.reset();
    viewing_.showLevels(showLevels);
    state_ = viewing_.state();
    if (!state_.problem.empty()) {
        tell(state_.problem, true);
        viewing_.problemSeen();
    }
    if (message_ && now > message_->until)
        message_.reset();
}

void Desk::send(bool moving) {
    if (!volume_)
        return;
    lastInput_ = WindowClock::now();
    if (askedAt_ == WindowClock::time_point())
        askedAt_ = lastInput_; // of the first input that no picture has answered
    asked_ = viewing_.show(scene_, moving);
    if (picked_)
        pickedBefore_ = picked_->number;
    picked_.reset();
    owesRest_ = moving;
}

void Desk::setScene(const Scene& scene, bool moving) {
    const glm::ivec2 size = scene_.imageSize;
    scene_ = scene;
    scene_.imageSize = size;
    send(moving);
}

void Desk::setCamera(const Camera& camera, bool moving) {
    scene_.camera = camera;
    send(moving);
}

void Desk::setFunction(const TransferFunction& function, bool moving) {
    scene_.volumes.front().transferFunction = function;
    send(moving);
}

void Desk::setPictureSize(const glm::ivec2& size) {
    if (size == wantedSize_)
        return;
    wantedSize_ = size;
    sizeChanged_ = WindowClock::now();
}

bool Desk::settle() {
    const auto now = WindowClock::now();
    if (volume_ && wantedSize_.x > 0 && wantedSize_ != scene_.imageSize) {
        if (now - sizeChanged_ < kSizeStays)
            return true;
        scene_.imageSize = wantedSize_;
        send(false);
    }
    if (owesRest_ && now - lastInput_ >= kRestAfter) {
        owesRest_ = false;
        asked_ = viewing_.show(scene_, false);
    }
    return owesRest_ || message_;
}

void Desk::setSlices(const SliceWish& wish) {
    slices_ = wish;
    viewing_.showSlices(wish);
}

void Desk::undo() {
    if (history_.canUndo())
        setScene(history_.undo(scene_), false);
}

void Desk::redo() {
    if (history_.canRedo())
        setScene(history_.redo(scene_), false);
}

void Desk::resetCamera() {
    if (volume_)
        setCamera(std::get<Camera>(volume_->scene.camera), false);
}

void Desk::open(const std::filesystem::path& path) {
    viewing_.open(path, wantedSize_.x > 0 ? wantedSize_ : Scene().imageSize);
}

template <typename Write> void Desk::save(const char* what, const char* extension, const Write& write) {
    if (!volume_)
        return;
    const std::string stem = volume_->path.stem().string();
    std::filesystem::path file = stem + extension;
    std::error_code ignored;
    for (int n = 2; std::filesystem::exists(file, ignored); ++n)
        file = stem + "-" + std::to_string(n) + extension;
    trying([&] {
        write(file);
        tell(std::string("wrote the ") + what + " " + std::filesystem::absolute(file, ignored).string());
    });
}

void Desk::savePicture() {
    save("picture", ".png", [&](const std::filesystem::path& file) { viewing_.saveScreenshot(file); });
}

void Desk::saveScene() {
    save("scene", ".json",
         [&](const std::filesystem::path& file) { writeOutputFile(file, sceneJson(scene_) + "\n"); });
}

void Desk::takePreset(const std::string& nameOrFile) {
    const auto names = presetNames();
    if (std::find(names.begin(), names.end(), nameOrFile) != names.end()) {
        const TransferFunction function = presetFunction(nameOrFile, volume_->values);
        beginEdit();
        setFunction(function, false);
        return;
    }
    std::vector<std::string> leftOut;
    const Preset found =
        overRange(presets_.find(nameOrFile, leftOut), volume_->values.lowest, volume_->values.highest);
    Scene scene = scene_;
    applyPreset(found, scene);
    beginEdit();
    setScene(scene, false);
    if (!leftOut.empty())
        tell(found.name + ": left out: " + joinNames(leftOut));
}

void Desk::keepPreset(const std::string& name) {
    presets_.keep(presetOf(scene_, name));
    tell("kept the preset " + name);
}

void Desk::writePreset(const std::filesystem::path& file, const std::string& format) {
    const auto leftOut = presets_.write(presetOf(scene_, file.stem().string()), file, format);
    std::error_code ignored;
    tell("wrote " + std::filesystem::absolute(file, ignored).string() +
         (leftOut.empty() ? "" : "; left out: " + joinNames(leftOut)));
}

void Desk::tell(const std::string& text, bool problem) {
    message_ = Message{text, problem, WindowClock::now() + (problem ? 12s : 4s)};
}

} // namespace tessera
