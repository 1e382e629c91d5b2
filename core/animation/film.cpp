// core/animation/film.cpp: see film.h.
#include "core/animation/film.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <numeric>
#include <string>

namespace tessera {
namespace {

/// The two keys around a moment, and the share between them.
struct Between {
    std::size_t key = 0;
    double share = 0;
};
Between between(const Pace& pace, double time) {
    const Pace::Moment moment = pace.at(time);
    return {moment.key, moment.value - static_cast<double>(moment.key)};
}

bool sameName(const TransferChoice& a, const TransferChoice& b) {
    const auto *x = std::get_if<std::string>(&a), *y = std::get_if<std::string>(&b);
    return x && y && *x == *y;
}

} // namespace

double Film::momentOf(const Keyframe& key) const {
    if (key.timeS)
        return *key.timeS;
    const Flight& flight = *path_.flight;
    const double from = flight.backwards
                            ? flight.toMm.value_or(routeOf(path_.lines, flight.route).back().alongMm)
                            : flight.fromMm;
    return std::abs(*key.placeMm - from) / flight.speedMmPerS;
}

template <typename T> Film::Track<T> Film::track(std::optional<T> Keyframe::*member) const {
    Track<T> out;
    std::vector<double> times, numbers;
    std::vector<Easing> easings;
    for (const Keyframe& key : path_.keyframes) {
        if (!(key.*member))
            continue;
        numbers.push_back(static_cast<double>(out.keys.size()));
        times.push_back(momentOf(key));
        easings.push_back(key.easing);
        out.keys.push_back(*(key.*member));
    }
    if (!out.keys.empty())
        out.pace.emplace(std::move(times), std::move(numbers), easings);
    return out;
}

Film::Film(Path path, Scene scene, Presets presets, const std::string& where)
    : path_(std::move(path)), scene_(std::move(scene)), presets_(std::move(presets)) {
    checkPath(path_, where);
    if (!path_.keyframes.empty())
        seconds_ = momentOf(path_.keyframes.back());
    if (path_.flight) {
        curve_.emplace(path_.lines, *path_.flight);
        // A flight with keyframes after its end waits there.
        seconds_ = std::max(seconds_, curve_->lengthMm() / path_.flight->speedMmPerS);
    } else {
        std::vector<double> times;
        std::vector<Camera> cameras;
        std::vector<Easing> easings;
        for (const Keyframe& key : path_.keyframes)
            if (key.camera) {
                times.push_back(momentOf(key));
                cameras.push_back(*key.camera);
                easings.push_back(key.easing);
            }
        if (cameras.empty())
            throw badFile(where, "a \"flight\", or keyframes with a camera", "neither");
        cameras_.emplace(times, cameras, easings, where);
    }
    look_ = track(&Keyframe::look);
    functions_ = track(&Keyframe::transferFunction);
    lights_ = track(&Keyframe::lighting);
    cuts_ = track(&Keyframe::cuts);
    if (look_.keys.size() > 1) {
        std::vector<double> numbers(look_.keys.size());
        std::iota(numbers.begin(), numbers.end(), 0.0);
        std::vector<std::vector<double>> values;
        for (const LookAround& look : look_.keys)
            values.push_back({look.yawDegrees, look.pitchDegrees, look.offsetMm.x, look.offsetMm.y});
        looks_.emplace(std::move(numbers), std::move(values));
    }
    // A film of 2 s at 25 frames/s has frames 0 to 50; rounding must not lose the last.
    frames_ = static_cast<std::size_t>(std::floor(seconds_ * path_.framesPerSecond + 1e-6)) + 1;
}

double Film::placeAt(double time) const {
    return std::clamp(time * path_.flight->speedMmPerS, 0.0, curve_->lengthMm());
}

Camera Film::cameraAt(double time) const {
    if (!curve_)
        return cameras_->at(time);
    LookAround look;
    if (looks_) {
        const std::vector<double> n = looks_->at(look_.pace->at(time).value);
        look = {n[0], n[1], {n[2], n[3]}};
    } else if (!look_.keys.empty()) {
        look = look_.keys.front();
    }
    return cameraOf(curve_->at(placeAt(time)), look, *path_.flight);
}

TransferChoice Film::functionAt(double time) const {
    const auto [key, share] = between(*functions_.pace, time);
    const TransferChoice& a = functions_.keys[key];
    if (key + 1 == functions_.keys.size() || share <= 0 || sameName(a, functions_.keys[key + 1]))
        return a;
    const auto function = [&](const TransferChoice& choice) {
        if (const auto* name = std::get_if<std::string>(&choice))
            return presets_(*name);
        return std::get<TransferFunction>(choice);
    };
    return blend(function(a), function(functions_.keys[key + 1]), share);
}

Scene Film::sceneAt(double time) const {
    Scene scene = scene_;
    scene.camera = cameraAt(time);
    if (functions_.pace)
        scene.volumes.front().transferFunction = functionAt(time);
    const auto take = [time](const auto& track, auto& target) {
        if (!track.pace)
            return;
        const auto [key, share] = between(*track.pace, time);
        target = key + 1 == track.keys.size() ? track.keys[key]
                                              : blend(track.keys[key], track.keys[key + 1], share);
    };
    take(lights_, scene.lighting);
    take(cuts_, scene.cuts);
    return scene;
}

Path turntable(const Camera& first, double degrees, std::size_t frames, double framesPerSecond) {
    constexpr double kMostDegrees = 3600;
    if (!(std::abs(degrees) <= kMostDegrees) || degrees == 0)
        throw badFile("--turn", "degrees from -3600 to 3600, not 0", std::to_string(degrees));
    if (frames < 2 || frames > Path::kMostKeyframes)
        throw badFile("--frames", "of a turn from 2 to " + std::to_string(Path::kMostKeyframes) + " frames",
                      std::to_string(frames));
    const bool closes = std::fmod(degrees, 360.0) == 0;
    const double step = glm::radians(degrees) / static_cast<double>(closes ? frames : frames - 1);
    Path path;
    path.framesPerSecond = framesPerSecond;
    for (std::size_t n = 0; n < frames; ++n) {
        const double angle = step * static_cast<double>(n), c = std::cos(angle), s = std::sin(angle);
        // About +z, by the right hand: from the front, -y, towards the patient's left, +x.
        const auto turned = [&](const glm::dvec3& v) {
            return glm::dvec3(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
        };
        Keyframe key;
        key.timeS = static_cast<double>(n) / framesPerSecond;
        key.easing = Easing::linear;
        key.camera = first;
        key.camera->position = first.focalPoint + turned(first.position - first.focalPoint);
        key.camera->viewUp = turned(first.viewUp);
        path.keyframes.push_back(key);
    }
    return path;
}

} // namespace tessera
