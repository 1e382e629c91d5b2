// viewer/window/boxes.h: widgets that several panels share: boxes that name the choice, and numbers as wide
// as their range asks for.
#pragma once

#include "core/scene/mode.h"
#include "viewer/window/window_state.h"

#include <imgui.h>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// A box of names.
/// @param chosen  what it says; none of the names where the user made something else
/// Returns the name that was taken.
std::optional<std::string> nameBox(const char* label, const std::string& chosen,
                                   const std::vector<std::string>& names);

/// A window of grey values: the box of names, centre and width. Returns the new one.
/// @param began  set where an edit begins
std::optional<GreyWindow> windowBox(const GreyWindow& window, const ValueSummary& values, bool& began);

/// A format for values of a range: as many decimals as tell a thousandth of it apart.
const char* formatFor(double range);

/// A step of 1, 2 or 5 times a power of ten that is at least so much.
double roundStep(double least);

/// Text that goes on in the next line where the panel ends.
void wrapped(const char* format, ...) IM_FMTARGS(1);

/// A label on a picture: letters on a dark plate, readable on anything.
/// @param at  its upper left corner
void drawLabel(ImDrawList& draw, const ImVec2& at, ImU32 colour, const std::string& words);

} // namespace tessera
