// viewer/window/script.h: a script of input for the window, for figures, measurements and tests. A line is a
// step; empty lines and those that begin with # are ignored:
//
//   open PATH                 wait volume | choice | picture | whole | still | rest | line | MILLISECONDS
//   wait samples N            of a pixel, where light follows paths
//   phase N                   another phase of the volume, from 1
//   choose N [PHASE]          of the volumes that a folder offers, from 1, once they are there (wait choice)
//   click X Y, double-click X Y, drag X Y X2 Y2    the left button, in units of the window
//   wheel X Y NOTCHES         key LETTER          a capital with Shift
//   orbit RIGHT UP            degrees          pan X Y         parts of the picture's height
//   zoom FACTOR               roll DEGREES     view SIDE       projection parallel|perspective
//   fit                       all that shows, from where one looks
//   turn DEGREES FRAMES       orbits in so many steps, each after the picture of the one before
//   preset NAME|FILE          keep-preset NAME, write-preset tessera|slicer|paraview FILE
//   light LOOK                shift VALUE FACTOR      of the transfer function
//   isosurface VALUE          size WxH         of the window
//   pick X Y [beside]         pixels of the picture, of the other scan's; prints what is there
//   picture FILE [TIMES]      saves the picture, or a still of so many times the pixels along a side; of both
//                             scans where there are two
//   link places coordinates|middles|auto    link look|cuts on|off      of two scans
//   window FILE.ppm           the whole window as it is shown
//   scene FILE                saves the scene            panels, planes, levels, help on|off
//   mode NAME                 window-of C,W|NAME        crop X0 X1 Y0 Y1 Z0 Z1   mm
//   place X Y Z               of the crosshair, mm
//   label all, label show|hide|only VALUE
//   line X Y Z X Y Z ...      a centre-line through places, mm; wait line     tree X Y Z   from one
//   fly-to MM, fly PICTURES   along it: to a place, through all of it in so many pictures
//   record                    a keyframe there          load-path, save-path FILE
//   legend on|off             shown, and drawn into saved pictures
//   print latency|state|memory|samples|message|planes|beside  quit
#pragma once

#include "viewer/window/endoscopy.h"
#include "viewer/window/window_state.h"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace tessera {

/// Position of the pointer, in units of the window, state of its left button, and notches of its wheel.
struct ScriptedHand {
    glm::dvec2 at{0};
    bool down = false;
    double wheel = 0;
};

class Script {
  public:
    /// Functions of the window that WindowState lacks.
    struct Window {
        std::function<void(const glm::ivec2&)> resize;
        std::function<void(const std::filesystem::path&)> capture; // what is shown, after the next frame
        std::function<void()> close;
        std::function<int()> countGlObjects;
        std::function<void()> loseContext; // as if the graphics device had been reset
        /// Input for the next frame.
        std::function<void(const ScriptedHand&)> point;
        std::function<void(int key, bool shift)> press; // as GLFW names keys
    };

    Script() = default; // none
    /// Throws InputError naming file and line for an invalid step.
    explicit Script(const std::filesystem::path& file);
    /// Takes steps until one must wait. Once a frame. Returns true if there are more. Throws InputError
    /// naming file and line for a step that fails.
    bool advance(WindowState& desk, Endoscopy& endoscopy, const Window& window);

  private:
    struct Step {
        int line = 0;
        std::vector<std::string> words;
    };
    [[noreturn]] void refuse(const Step& step, const std::string& expected) const;
    double number(const Step& step, std::size_t word) const;
    bool take(const Step& step, WindowState& desk, Endoscopy& endoscopy, const Window& window);
    void takeLabel(const Step& step, WindowState& desk);
    bool takePhase(const Step& step, WindowState& desk);
    bool takeEndoscopy(const Step& step, WindowState& desk, Endoscopy& endoscopy, bool& taken);
    bool waits(const Step& step, WindowState& desk, const Endoscopy& endoscopy);
    void takeLink(const Step& step, WindowState& desk);
    bool takePick(const Step& step, WindowState& desk);
    void print(const Step& step, WindowState& desk, const Window& window);
    bool takeHand(const Step& step, const Window& window);

    std::filesystem::path file_;
    std::vector<Step> steps_;
    std::size_t next_ = 0;
    int turned_ = 0;                // frames of a turn
    std::size_t handed_ = 0;        // frames of a click or a drag
    std::uint64_t pictures_ = 0;    // when the step began
    std::uint64_t question_ = 0;    // of a pick
    WindowClock::time_point began_; // of the step
    int phaseLooks_ = 0;            // for the phase that a step opens
    bool stepBegan_ = false;
};

} // namespace tessera
