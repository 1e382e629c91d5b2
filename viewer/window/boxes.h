// viewer/window/boxes.h: widgets that several panels share: boxes of names, and numbers formatted for their
// range.
#pragma once

#include "core/scene/mode.h"
#include "viewer/window/window_state.h"

#include <imgui.h>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// A box of names.
/// @param chosen  its text; none of the names for a custom choice
/// Returns the chosen name.
std::optional<std::string> nameBox(const char* label, const std::string& chosen,
                                   const std::vector<std::string>& names);

/// A window of grey values: the box of names, centre and width. Returns the new one.
/// @param began  set where an edit begins
std::optional<GreyWindow> windowBox(const GreyWindow& window, const ValueSummary& values, Mode mode,
                                    bool& began);

/// A format for values of a range: enough decimals for a thousandth of it.
const char* formatFor(double range);

/// The smallest step of 1, 2 or 5 times a power of ten that is at least the argument.
double roundStep(double least);

enum class EyeState { open, some, shut };
/// A button that tells whether something shows; the next widget stands beside it. Returns true if clicked.
bool eyeButton(EyeState state);
/// Linear light for the screen.
glm::vec3 screenRgb(const glm::dvec3& linear);

/// Text wrapped at the panel's edge.
void wrapped(const char* format, ...) IM_FMTARGS(1);

/// A label on a picture: letters on a dark plate, readable on any background.
/// @param at  its upper left corner
void drawLabel(ImDrawList& draw, const ImVec2& at, ImU32 colour, const std::string& words);

} // namespace tessera
