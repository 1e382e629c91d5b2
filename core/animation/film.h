// core/animation/film.h: the scene of every frame of a film, from a scene and a path. A frame follows from
// its number alone, so frames can be drawn in any order, by any process.
#pragma once

#include "core/animation/blend.h"
#include "core/animation/flight.h"
#include "core/animation/path.h"
#include "core/scene/scene.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace tessera {

class Film {
  public:
    using Presets = std::function<TransferFunction(const std::string& name)>;
    /// @param scene  what no keyframe says
    /// @param presets  a preset's function, where it goes over into another one
    /// Throws InputError naming where for a path that gives no camera: neither flown nor with a keyframe's.
    Film(Path path, Scene scene, Presets presets, const std::string& where);

    /// Frame i is at i / framesPerSecond; the last one at the end or less than a frame before it. At least 1.
    std::size_t frames() const { return frames_; }
    double seconds() const { return seconds_; }
    double timeOf(std::size_t frame) const { return static_cast<double>(frame) / path_.framesPerSecond; }
    /// The scene of that moment, its camera spelled out.
    Scene scene(std::size_t frame) const { return sceneAt(timeOf(frame)); }
    Scene sceneAt(double time) const;
    Camera cameraAt(double time) const;
    /// With a flight: along it.
    double placeAt(double time) const;
    const std::optional<FlightCurve>& curve() const { return curve_; }
    const Path& path() const { return path_; }
    /// True if anything but the camera changes between frames.
    bool onlyCameraMoves() const {
        return functions_.keys.empty() && lights_.keys.empty() && cuts_.keys.empty();
    }

  private:
    template <typename T> struct Track { // of what some keyframes say
        std::vector<T> keys;
        std::optional<Pace> pace; // over the keys' numbers
    };
    double momentOf(const Keyframe& key) const;
    template <typename T> Track<T> track(std::optional<T> Keyframe::*member) const;
    TransferChoice functionAt(double time) const;

    Path path_;
    Scene scene_;
    Presets presets_;
    std::optional<FlightCurve> curve_;
    std::optional<CameraCurve> cameras_;
    std::optional<Spline> looks_; // over the looks' numbers
    Track<LookAround> look_;
    Track<TransferChoice> functions_;
    Track<Lighting> lights_;
    Track<Cuts> cuts_;
    double seconds_ = 0;
    std::size_t frames_ = 1;
};

// A turntable film: a camera's circle about its focal point, as a path of keyframes.

/// One keyframe a frame, at equal angles about the patient's axis (from feet to head) through the camera's
/// focal point. With degrees above 0 the viewer moves towards the patient's left. Full turns leave out the
/// last frame, which would equal the first; others end at `degrees`. Throws InputError naming --turn and
/// --frames for an angle of 0 or more than 3600 degrees, and for fewer than 2 frames or more than a path may
/// have.
Path turntable(const Camera& first, double degrees, std::size_t frames, double framesPerSecond);

} // namespace tessera
