// bricking/import/files/stack/stack_values.cpp: see stack_values.h. Rules: ij.io.FileSaver and
// ij.measure.Calibration of ImageJ 1.53.
#include "bricking/import/files/stack/stack_values.h"

#include "bricking/import/files/header_words.h"
#include "bricking/import/files/stack/imagej_lines.h"
#include "bricking/import/source/plausible.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tessera {
namespace {

constexpr std::int64_t kStraightLine = 0, kNone = 20;

/// As ImageJ's dialogue names them.
std::string functionName(std::int64_t number, const std::string& text) {
    struct Function {
        std::int64_t number;
        const char* name;
    };
    static constexpr std::array kFunctions = {Function{1, "2nd Degree Polynomial"},
                                              Function{2, "3rd Degree Polynomial"},
                                              Function{3, "4th Degree Polynomial"},
                                              Function{4, "Exponential"},
                                              Function{5, "Power"},
                                              Function{6, "Log"},
                                              Function{7, "Rodbard"},
                                              Function{8, "Gamma Variate"},
                                              Function{9, "y = a+b*ln(x-c)"},
                                              Function{10, "Rodbard (NIH Image)"},
                                              Function{11, "Exponential with Offset"},
                                              Function{12, "Gaussian"},
                                              Function{13, "Exponential Recovery"},
                                              Function{21, "Uncalibrated OD"},
                                              Function{22, "Custom"}};
    const auto* const row =
        std::ranges::find_if(kFunctions, [&](const Function& each) { return each.number == number; });
    return shownWord(row == kFunctions.end() ? "function " + text : row->name);
}

} // namespace

StackRescale rescaleOf(const PictureHead& head, const std::string& where) {
    StackRescale rescale;
    if (!isOfImageJ(head.description))
        return rescale;
    const std::string& text = head.description;
    if (imageJLine(text, "vunit") == "HU")
        rescale.unit = "HU";
    const std::string function = imageJLine(text, "cf");
    if (function.empty())
        return rescale;
    const std::int64_t number = wholeNumberOf(function).value_or(-1);
    if (number == kNone)
        return rescale;
    if (number != kStraightLine)
        throw badFile(where, "values calibrated by a straight line (cf=0 in ImageJ's description), or not",
                      functionName(number, function));
    const std::optional<double> intercept = realNumberOf(imageJLine(text, "c0")),
                                slope = realNumberOf(imageJLine(text, "c1"));
    if (!intercept || !slope)
        throw badFile(where, "numbers c0 and c1 of ImageJ's calibration",
                      shownWord(imageJLine(text, "c0")) + " and " + shownWord(imageJLine(text, "c1")));
    if (imageJLine(text, "zeroclip") == "true")
        throw badFile(where, "a calibration by ImageJ that keeps all values", "zeroclip=true");
    const FileType type = head.shape.type;
    if (type != FileType::u8 && type != FileType::u16)
        throw badFile(where, "whole numbers of 8 or 16 bits without a sign, which ImageJ calibrates",
                      name(type));
    rescale.slope = *slope;
    rescale.intercept = *intercept;
    requirePlausibleRescale(
        rescale.slope, rescale.intercept, std::ldexp(1.0, static_cast<int>(8 * bytesPerFileValue(type))),
        rescale.unit == "HU", "c1 of ImageJ's calibration", "c0 of ImageJ's calibration", where);
    return rescale;
}

} // namespace tessera
