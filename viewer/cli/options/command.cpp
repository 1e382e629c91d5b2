// viewer/cli/options/command.cpp: see command.h.
#include "viewer/cli/options/command.h"

#include "core/base/decimal.h"
#include "core/base/error.h"
#include "core/base/names.h"
#include "core/base/output_file.h" // finishStandardOutput

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <sstream>
#include <utility>

namespace tessera {
namespace {

std::string refusal(const std::string& expected, const std::string& found) {
    constexpr std::size_t kShown = 40;
    return "expected " + expected + ", found \"" + found.substr(0, kShown) + "\"";
}

void refuseEmptyValues(const CLI::App& program) {
    for (const CLI::Option* option : program.get_options())
        for (const std::string& value : option->results())
            if (value.empty())
                throw badFile(option->get_name(), option->get_description(), "\"" + value + "\"");
    for (const CLI::App* command : program.get_subcommands())
        refuseEmptyValues(*command);
}

std::vector<std::string> commandNames(const CLI::App& program) {
    std::vector<std::string> names;
    for (const CLI::App* command : program.get_subcommands({}))
        names.push_back(command->get_name());
    return names;
}

/// A mistyped command, or one of a command's own, found before the parser, which would only say that one is
/// missing.
void checkCommand(const CLI::App& program, char** from, char** end, const std::string& of = "") {
    const auto isWord = [](const char* argument) { return argument[0] != '-'; };
    char** const word = std::find_if(from, end, isWord);
    if (word == end)
        return;
    const std::vector<std::string> names = commandNames(program);
    if (std::find(names.begin(), names.end(), *word) == names.end())
        throw badFile("command line", "a command" + of + " (" + joinNames(names) + ")",
                      "\"" + std::string(*word) + "\"; nearest: \"" + nearestName(*word, names) + "\"");
    if (const CLI::App& command = *program.get_subcommand(*word); command.get_require_subcommand_min() > 0)
        checkCommand(command, word + 1, end, " of " + command.get_name());
}

/// The parser's complaint, with the nearest option where one was unknown.
std::string explainParseError(const CLI::App& program, const CLI::ParseError& error) {
    std::string message = error.what();
    std::replace(message.begin(), message.end(), '\n', ' ');
    std::vector<std::string> options;
    const auto collect = [&options](const CLI::App& app) {
        for (const CLI::Option* option : app.get_options())
            for (const std::string& longName : option->get_lnames())
                options.push_back("--" + longName);
    };
    collect(program);
    std::string command;
    for (const CLI::App* chosen : program.get_subcommands()) {
        collect(*chosen);
        command = " " + chosen->get_name();
    }
    const std::string more = ": At Most 1 required but received "; // as the parser has it
    if (const std::size_t at = message.find(more); at != std::string::npos)
        message =
            message.substr(0, at) + ": expected once, found " + message.substr(at + more.size()) + " times";
    const std::vector<std::string> extras = program.remaining(true);
    const auto unknown = std::find_if(extras.begin(), extras.end(),
                                      [](const std::string& extra) { return extra.rfind("--", 0) == 0; });
    if (unknown != extras.end()) {
        const std::string likely = likelyOption(*unknown, options);
        message = "unknown option " + *unknown + (likely.empty() ? "" : "; nearest: " + likely);
    }
    return message + " (tessera" + command + " --help shows how)";
}

} // namespace

ValueCheck wholeNumberFrom(int lowest) {
    return [lowest](const std::string& text) {
        int number = 0;
        const char* const end = text.data() + text.size();
        const auto [stopped, error] = std::from_chars(text.data(), end, number);
        return error == std::errc() && stopped == end && number >= lowest
                   ? std::string()
                   : refusal("a whole number from " + std::to_string(lowest), text);
    };
}

ValueCheck numberWithin(double lowest, double highest, const std::string& what) {
    return [lowest, highest, what](const std::string& text) {
        const std::optional<double> number = decimalNumber(text);
        return number && *number >= lowest && *number <= highest ? std::string() : refusal(what, text);
    };
}

std::string withoutUnit(const std::string& text, const std::string& unit) {
    if (!text.ends_with(unit))
        return text;
    const std::string number = text.substr(0, text.size() - unit.size());
    const std::size_t end = number.find_last_not_of(' ');
    return end == std::string::npos ? text : number.substr(0, end + 1);
}

std::optional<std::vector<double>> lengthsOf(const std::string& text, std::size_t count) {
    std::vector<double> lengths;
    std::istringstream words(text);
    for (std::string word; std::getline(words, word, ',');) {
        const std::optional<double> length = decimalNumber(withoutUnit(word, "mm"));
        if (!length)
            return {};
        lengths.push_back(*length);
    }
    if (lengths.size() != count || text.ends_with(','))
        return {};
    return lengths;
}

Option& Option::required() {
    option_->required();
    return *this;
}
Option& Option::check(const ValueCheck& check) {
    option_->check(CLI::Validator([check](std::string& text) { return check(text); }, ""));
    return *this;
}
Option& Option::inUnit(const std::string& unit) {
    option_->transform(CLI::Validator(
        [unit](std::string& text) {
            text = withoutUnit(text, unit);
            return std::string();
        },
        ""));
    return *this;
}
Option& Option::takes(const std::string& type) {
    option_->type_name(type);
    return *this;
}
Option& Option::showsDefault() {
    option_->capture_default_str();
    return *this;
}
Option& Option::needs(const std::string& other) {
    option_->needs(other);
    return *this;
}
Option& Option::excludes(const std::string& other) {
    option_->excludes(other);
    return *this;
}
Option& Option::oneValueEach() {
    option_->allow_extra_args(false);
    return *this;
}

Option Command::option(const std::string& names, std::string& target, const std::string& about) {
    return Option(*app_->add_option(names, target, about));
}
Option Command::option(const std::string& names, std::vector<std::string>& target, const std::string& about) {
    return Option(*app_->add_option(names, target, about));
}
Option Command::option(const std::string& names, int& target, const std::string& about) {
    return Option(*app_->add_option(names, target, about));
}
Option Command::option(const std::string& names, double& target, const std::string& about) {
    return Option(*app_->add_option(names, target, about));
}
Option Command::option(const std::string& names, std::optional<double>& target, const std::string& about) {
    return Option(*app_->add_option(names, target, about));
}
Option Command::option(const std::string& names, const std::function<void(const std::string&)>& take,
                       const std::string& about) {
    return Option(*app_->add_option_function<std::string>(names, take, about));
}
Option Command::flag(const std::string& names, bool& target, const std::string& about) {
    return Option(*app_->add_flag(names, target, about));
}
Command Command::command(const std::string& name, const std::string& about) {
    return Command(*app_->add_subcommand(name, about));
}
void Command::needsCommand() {
    app_->require_subcommand(1);
}
void Command::footer(const std::string& text) {
    app_->footer(text);
}
void Command::whenChosen(std::function<void()> callback) {
    app_->callback(std::move(callback));
}

CommandLine::CommandLine(const std::string& name, const std::string& version, const std::string& about)
    : app_(std::make_unique<CLI::App>(about)) {
    app_->name(name);
    app_->set_version_flag("--version", name + " " + version);
    app_->fallthrough();
    app_->require_subcommand(1);
}
CommandLine::~CommandLine() = default;

std::optional<int> CommandLine::parse(int argc, char** argv) {
    checkCommand(*app_, argv + 1, argv + argc);
    try {
        app_->parse(argc, argv);
    } catch (const CLI::Success& success) { // --help, --version
        const int code = app_->exit(success);
        finishStandardOutput();
        return code;
    } catch (const CLI::ParseError& error) {
        throw InputError(explainParseError(*app_, error));
    }
    refuseEmptyValues(*app_);
    return std::nullopt;
}

namespace {

/// Synonyms from ParaView, VTK, 3D Slicer, ffmpeg and radiology. The first option that the command has is
/// used.
const std::vector<std::pair<const char*, std::vector<const char*>>>& otherWords() {
    static const std::vector<std::pair<const char*, std::vector<const char*>>> words = {
        {"--preset",
         {"colour", "color", "colours", "colors", "colormap", "colourmap", "palette", "lut", "tf", "transfer",
          "transfer-function", "opacity", "style"}},
        {"--mode", {"mip", "minip", "blend-mode", "blend", "projection-mode", "render-mode", "ray-mode"}},
        {"--window", {"level", "window-level", "wl", "ww", "contrast", "brightness"}},
        {"--slice", {"mpr", "plane", "reslice", "axial", "coronal", "sagittal", "oblique"}},
        {"--crop", {"box", "roi", "cropping", "clip-box", "crop-box", "bounds", "region"}},
        {"--cut-plane", {"clip", "clip-plane", "clipping", "clipping-plane", "cut"}},
        {"--slab", {"thickness", "thick", "slab-thickness", "slab-mode"}},
        {"--light",
         {"lights", "lighting", "illumination", "shadow", "shadows", "ao", "occlusion", "ambient-occlusion",
          "studio"}},
        {"--background", {"bg", "back", "background-color", "background-colour"}},
        {"--size", {"width", "height", "resolution", "res", "dimensions", "dims", "pixels", "geometry"}},
        {"--view", {"camera", "angle", "side", "orientation", "direction", "from", "look"}},
        {"--fit", {"zoom", "frame", "framing", "fov"}},
        {"--projection", {"ortho", "orthographic", "parallel", "perspective"}},
        {"--output", {"out", "outfile", "file", "save", "dest", "to"}},
        {"--ram", {"memory", "mem", "max-memory", "cache"}},
        {"--gpu-memory", {"vram", "gpu-mem", "video-memory", "texture-memory"}},
        {"--gl-device", {"gpu", "device", "gl", "egl", "software", "cpu"}},
        {"--isosurface", {"iso", "isovalue", "surface", "threshold", "contour", "level"}},
        {"--max-error", {"quality", "accuracy", "error", "tolerance"}},
        {"--samples",
         {"spp", "aa", "antialias", "anti-alias", "antialiasing", "anti-aliasing", "supersampling", "msaa"}},
        {"--verify", {"check", "measure", "validate", "test"}},
        {"--step", {"steps", "spacing", "distance", "sample-distance", "rate", "sampling-rate"}},
        {"--no-shading",
         {"shading", "shade", "light", "lighting", "lights", "unlit", "no-light", "no-lighting"}},
        {"--gradient", {"normals", "normal", "smooth", "derivative"}},
        {"--fetch", {"interpolation", "filter", "filtering", "nearest", "linear"}},
        {"--first", {"preview", "coarse", "progressive", "draft"}},
        {"--quiet", {"silent", "no-progress", "batch"}},
        {"--verbose", {"progress", "debug", "log", "loud"}},
        {"--force", {"overwrite", "replace", "yes", "clobber"}},
        {"--largest", {"biggest", "all"}},
        {"--resample-z", {"resample", "even", "interpolate"}},
        {"--allow-missing", {"ignore-missing", "skip-missing", "incomplete", "skip-damaged", "partial"}},
        {"--phase", {"time", "timepoint", "time-point", "temporal", "cardiac-phase", "echo"}},
        {"--scans", {"data", "datasets", "input"}},
        {"--json", {"manifest", "format", "machine-readable"}},
        {"--explain", {"stats", "statistics", "info", "describe"}},
    };
    return words;
}

std::string plain(const std::string& option) {
    std::string word = option.substr(0, option.find('='));
    word.erase(0, word.find_first_not_of('-'));
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return c == '_' ? '-' : static_cast<char>(std::tolower(c)); });
    return word;
}

/// True if one of the words between hyphens begins with it.
bool hasPart(const std::string& option, const std::string& part) {
    std::istringstream words(plain(option));
    for (std::string word; std::getline(words, word, '-');)
        if (word.rfind(part, 0) == 0)
            return true;
    return plain(option).rfind(part, 0) == 0;
}

} // namespace

std::string likelyOption(const std::string& unknown, const std::vector<std::string>& known) {
    const std::string word = plain(unknown);
    const auto isKnown = [&](const char* name) {
        return std::find(known.begin(), known.end(), name) != known.end();
    };
    const std::string nearest = nearestName("--" + word, known);
    const std::size_t away = editDistance("--" + word, nearest);
    if (away <= 1)
        return nearest; // a slip of a finger
    for (const auto& [option, others] : otherWords())
        if (isKnown(option) && std::find(others.begin(), others.end(), word) != others.end())
            return option;
    constexpr std::size_t kTelling = 3; // letters; fewer match too many options
    if (word.size() >= kTelling)
        for (const std::string& option : known)
            if (hasPart(option, word))
                return option;
    constexpr std::size_t kSlips = 2; // letters swapped, or two keys beside the right ones
    return away <= std::max(kSlips, word.size() / 3) && word.size() > kSlips ? nearest : std::string();
}

} // namespace tessera
