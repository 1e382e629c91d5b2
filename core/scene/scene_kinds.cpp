// core/scene/scene_kinds.cpp: values of scenes that are more than one number or name, as files have them: see
// scene_fields.h.
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/image/colour.h"
#include "core/scene/scene_fields.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace tessera {
namespace {

/// The nearest colour with eight bits of sRGB: "#rrggbb".
std::string hexColour(const glm::vec3& linear) {
    std::array<char, 8> hex{};
    const auto byte = [&](int c) {
        return static_cast<unsigned>(std::lround(srgbFromLinear(static_cast<double>(linear[c])) * 255));
    };
    std::snprintf(hex.data(), hex.size(), "#%02x%02x%02x", byte(0) & 255, byte(1) & 255, byte(2) & 255);
    return hex.data();
}

bool isTypedText(const JsonValue& value) {
    return value.isTyped() && value.isText();
}
std::string quoted(const std::string& text) {
    return "\"" + text.substr(0, 40) + "\"";
}

/// Numbers from least to most, and auto, which is another one.
struct NumberOrAuto {
    int least = 0, most = 0, automatic = 0;
    std::string expected; // of a number, for errors
};
int parseOrAuto(const std::string& text, const std::string& where, const NumberOrAuto& of) {
    constexpr std::size_t kMostDigits = 9;
    if (text == "auto")
        return of.automatic;
    if (text.empty() || text.size() > kMostDigits ||
        text.find_first_not_of("0123456789") != std::string::npos || std::stoi(text) < of.least ||
        std::stoi(text) > of.most)
        throw badFile(where, "auto or " + of.expected, quoted(text));
    return std::stoi(text);
}

constexpr int kMostFileLevel = 63, kMostVoxel = 1 << 30;
constexpr const char* kBoxExpected = "X0,X1,Y0,Y1,Z0,Z1: voxels from 0, each second one above the first";

NumberOrAuto fileLevelNumbers() {
    return {0, kMostFileLevel, SourceChoice::kAutoLevel,
            "a level of the file from 0 (finest) to " + std::to_string(kMostFileLevel)};
}

FileBox checkedBox(const std::vector<int>& n, const std::string& where, const std::string& found) {
    const FileBox box{{n[0], n[2], n[4]}, {n[1], n[3], n[5]}};
    for (int axis = 0; axis < 3; ++axis)
        if (box.low[axis] >= box.high[axis])
            throw badFile(where, kBoxExpected, found);
    return box;
}

} // namespace

FileBox parseFileBox(const std::string& text, const std::string& where) {
    constexpr std::size_t kNumbers = 6, kMostDigits = 10;
    std::vector<int> numbers;
    std::size_t from = 0;
    for (std::size_t end = 0; end != std::string::npos && numbers.size() <= kNumbers; from = end + 1) {
        end = text.find(',', from);
        const std::string part = text.substr(from, end == std::string::npos ? end : end - from);
        if (part.empty() || part.size() > kMostDigits ||
            part.find_first_not_of("0123456789") != std::string::npos || std::stoll(part) > kMostVoxel)
            throw badFile(where, kBoxExpected, quoted(text));
        numbers.push_back(static_cast<int>(std::stoll(part)));
    }
    if (numbers.size() != kNumbers)
        throw badFile(where, kBoxExpected, quoted(text));
    return checkedBox(numbers, where, quoted(text));
}

int parseFileLevel(const std::string& text, const std::string& where) {
    return parseOrAuto(text, where, fileLevelNumbers());
}

namespace {

Kind<int> numberOrAuto(const NumberOrAuto& of) {
    const Kind<int> number = wholeIn(of.least, of.most);
    return {[=](const JsonValue& value) {
                if (isTypedText(value))
                    return parseOrAuto(value.text(), value.place(), of);
                return value.isText() ? (value.oneOf({"auto"}), of.automatic) : number.read(value);
            },
            [=](int n) { return n == of.automatic ? nlohmann::json("auto") : nlohmann::json(n); },
            [=](Schema& parts) {
                return Schema{{"oneOf", {{{"enum", {"auto"}}}, number.schema(parts)}}};
            }};
}

} // namespace

Kind<int> numberOrAuto(int most) {
    return numberOrAuto({1, most, 0, "a whole number from 1 to " + std::to_string(most)});
}

Kind<int> fileLevelKind() {
    return numberOrAuto(fileLevelNumbers());
}

Kind<FileBox> fileBoxKind() {
    const Kind<std::vector<int>> list = listOf(wholeIn(0, kMostVoxel), 6, 6, "[x0, x1, y0, y1, z0, z1]");
    return {[=](const JsonValue& value) {
                if (isTypedText(value))
                    return parseFileBox(value.text(), value.place());
                return checkedBox(list.read(value), value.place(), "another order");
            },
            [](const FileBox& box) {
                const auto& [low, high] = box;
                return nlohmann::json::array({low.x, high.x, low.y, high.y, low.z, high.z});
            },
            list.schema};
}

Kind<glm::dvec3> vectorKind() {
    Kind<glm::dvec3> kind = numbersAt<glm::dvec3>(&glm::dvec3::x, &glm::dvec3::y, &glm::dvec3::z);
    kind.schema = [list = kind.schema](Schema& parts) {
        parts["vector"] = list(parts);
        return Schema{{"$ref", "#/$defs/vector"}};
    };
    return kind;
}

Kind<glm::dvec3> colourKind() {
    return numbersWithin<glm::dvec3>(0, 1, "[r, g, b], linear", &glm::dvec3::r, &glm::dvec3::g,
                                     &glm::dvec3::b);
}

Kind<Projection> projectionKind() {
    return {[](const JsonValue& value) {
                return value.boolean() ? Projection::parallel : Projection::perspective;
            },
            [](Projection projection) { return nlohmann::json(projection == Projection::parallel); },
            trueOrFalse().schema};
}

Kind<std::string> unitKind() {
    Kind<std::string> kind = oneOf({"", "HU"});
    kind.read = [read = kind.read](const JsonValue& value) {
        if (isTypedText(value) && !value.text().empty() && value.text() != "HU")
            throw badFile(value.place(), "HU; SUVbw is for tessera import", quoted(value.text()));
        return read(value);
    };
    return kind;
}

Kind<WindowChoice> windowKind() {
    const Kind<GreyWindow> numbers = numbersAt<GreyWindow>(&GreyWindow::centre, &GreyWindow::width);
    return {[=](const JsonValue& value) -> WindowChoice {
                if (isTypedText(value))
                    return parseWindow(value.text(), value.place());
                if (value.isText())
                    return value.oneOf(windowNames());
                const GreyWindow window = numbers.read(value);
                return checkedWindow(window.centre, window.width, value.place());
            },
            [=](const WindowChoice& choice) {
                const auto* const window = std::get_if<GreyWindow>(&choice);
                return window ? numbers.write(*window) : nlohmann::json(std::get<std::string>(choice));
            },
            [=](Schema& parts) {
                return Schema{{"oneOf", {{{"enum", windowNames()}}, numbers.schema(parts)}}};
            }};
}

Kind<glm::ivec2> sizeKind() {
    const Kind<std::vector<int>> list = listOf(wholeIn(1, Scene::kMaxImageExtent), 2, 2, "[width, height]");
    return {[=](const JsonValue& value) {
                if (isTypedText(value))
                    return parseImageSize(value.text(), value.place(), Scene::kMaxImageExtent);
                const std::vector<int> size = list.read(value);
                return glm::ivec2(size[0], size[1]);
            },
            [](const glm::ivec2& size) {
                return nlohmann::json::array({size.x, size.y});
            },
            list.schema};
}

Kind<std::optional<glm::vec3>> backgroundKind() {
    const Kind<glm::dvec3> linear = colourKind(); // for colours that eight bits of sRGB cannot express
    return {[=](const JsonValue& value) -> std::optional<glm::vec3> {
                if (value.isList())
                    return glm::vec3(linear.read(value));
                return parseBackground(value.text(), value.place());
            },
            [=](const std::optional<glm::vec3>& background) -> nlohmann::json {
                if (!background)
                    return "transparent";
                const std::string hex = hexColour(*background);
                if (parseBackground(hex, "background") == background)
                    return hex;
                return linear.write(glm::dvec3(*background));
            },
            [=](Schema& parts) {
                const char* const words = "^(transparent|#[0-9a-fA-F]{6}|[a-zA-Z]+)$";
                return Schema{{"oneOf", {{{"type", "string"}, {"pattern", words}}, linear.schema(parts)}}};
            }};
}

} // namespace tessera
