// viewer/cli/preset.cpp: `tessera preset`: what presets there are, and presets from one program's file
// to another's.
#include "core/scene/preset.h"
#include "core/base/error.h"
#include "core/base/names.h"
#include "viewer/cli/commands.h"
#include "viewer/presets/preset_library.h"

#include <cstdio>
#include <cstdlib>
#include <memory>

namespace tessera {
namespace {

struct PresetArguments {
    std::string name, out, format, range, keep;
    bool forget = false;
};

void list() {
    for (const std::string& name : presetNames())
        std::printf("%-14s %s\n", name.c_str(), presetDescription(name).c_str());
    for (const std::string& name : ownPresetNames()) {
        std::string about;
        try {
            about = findPreset(name).preset.description;
        } catch (const Error& e) { // one bad file hides no other
            about = e.what();
        }
        std::printf("%-14s %s\n", name.c_str(), about.empty() ? "(yours)" : about.c_str());
    }
}

/// "LOW,HIGH"
glm::dvec2 parseRange(const std::string& text) {
    glm::dvec2 range(0);
    char* end = nullptr;
    range.x = std::strtod(text.c_str(), &end);
    const char* const second = *end == ',' ? end + 1 : "";
    range.y = std::strtod(second, &end);
    if (end == second || *end != '\0')
        throw badFile("--range", "LOW,HIGH", "\"" + text.substr(0, 40) + "\"");
    return range;
}

void run(const PresetArguments& arguments, const CommonOptions& common) {
    if (arguments.name.empty()) {
        list();
        return;
    }
    if (arguments.forget) {
        forgetPreset(arguments.name);
        return;
    }
    FoundPreset found;
    if (isOwnOrFile(arguments.name)) {
        found = findPreset(arguments.name);
    } else {
        if (arguments.name == "auto")
            throw badFile("preset", "a function, which \"auto\" becomes by a volume's values", "\"auto\"");
        found.preset = builtInPreset(arguments.name);
    }
    if (!arguments.range.empty()) {
        const glm::dvec2 range = parseRange(arguments.range);
        found.preset = overRange(found.preset, range.x, range.y);
    }
    for (const std::string& what : found.leftOut)
        common.note("left out: " + what);
    if (!arguments.keep.empty()) {
        found.preset.name = arguments.keep;
        common.note("kept as " + keepPreset(found.preset).string());
    }
    if (!arguments.out.empty())
        for (const std::string& what : writePreset(found.preset, arguments.out, arguments.format))
            common.note("left out: " + what);
    if (arguments.out.empty() && arguments.keep.empty())
        std::printf("%s", presetJson(found.preset).c_str());
}

} // namespace

void addPresetCommand(Command& program, const CommonOptions& common, Action& action) {
    const auto a = std::make_shared<PresetArguments>();
    Command command =
        program.command("preset", "List presets; show, convert or keep one (Tessera, 3D Slicer, ParaView)");
    command.option("preset", a->name,
                   "a name, or a file of Tessera (preset or scene), 3D Slicer (.vp.json, .vp, MRML) or "
                   "ParaView (JSON); FILE#NAME if it holds several");
    command.option("-o,--output", a->out, "file to write (default: print it as JSON)");
    command
        .option("--format", a->format,
                joinNames(presetFormatNames()) + " (default: slicer for .vp.json, else tessera)")
        .offers(presetFormatNames())
        .needs("--output");
    command.option("--range", a->range, "LOW,HIGH: the values of 0 and 1 in a normalised map");
    command.option("--keep", a->keep, "keep it under this name, for --preset and the window");
    command.flag("--forget", a->forget, "remove a kept preset");
    command.footer("Example:\n  tessera preset \"presets.xml#CT-Bone\" --keep slicer-bone\n"
                   "  tessera render abdomen.zarr -o bone.png --preset slicer-bone");
    command.whenChosen([a, &common, &action] { action = [a, &common] { run(*a, common); }; });
}

} // namespace tessera
