// tests/bench/bench_command.cpp: `tessera bench lod -o FOLDER`, `tessera bench memory` and `tessera bench
// picture`: the measurements behind docs/measurements/level-of-detail.md and
// docs/measurements/first-picture.md, made again by one command each.
#include "core/base/error.h"
#include "core/base/names.h"
#include "core/base/program_folders.h"
#include "render/backends/engine_maker.h"
#include "tests/bench/lod/edge_functions.h"
#include "tests/bench/lod/experiments.h"
#include "tests/bench/memory/memory_budgets.h"
#include "tests/bench/papers/papers.h"
#include "tests/bench/report/page.h"
#include "tests/bench/study_commands.h"

#include <algorithm>
#include <map>
#include <memory>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using namespace bench;

struct BenchArguments {
    std::string out, scans, ram, engine = "auto", device = "auto";
    std::vector<std::string> only, volumes;
    bool quick = false;
};

struct Experiment {
    const char* name;
    Report (*onVolumes)(const Workbench&); // null: needs no volume
    VolumeSet volumes;
};
/// A page of docs/ and what is measured for it.
struct Page {
    const char* name;    // of its file
    const char* command; // that makes it again
    const char* heading;
    std::vector<Experiment> experiments; // in the order of the page
};

std::vector<std::string> experimentNames(const Page& page) {
    std::vector<std::string> names;
    for (const Experiment& experiment : page.experiments)
        names.emplace_back(experiment.name);
    return names;
}

constexpr const char* kLevelsHeading =
    "# Level of detail: what was measured\n\n"
    "Every brick has its own level, chosen within a budget (flat multiresolution). This page is generated, "
    "with "
    "its figures and the CSV files beside it, by\n\n"
    "    tessera bench lod -o docs --scans FOLDER\n\n"
    "and each section says how, where and with which volumes it was made. `--only NAME` makes one section "
    "again. "
    "Sources: course notes on advanced volume ray casting, sections 2.9.3 to 2.11, whose figures and tables "
    "are "
    "named; they number levels the other way round. Errors are distances in CIE 1976 L*u*v*.\n";

constexpr const char* kPictureHeading =
    "# The first picture: what was measured\n\n"
    "What a person sees of a volume without asking for anything: how well it fills the picture, and how "
    "smooth its "
    "surfaces look. This page is generated, with its figures and the CSV files beside it, by\n\n"
    "    tessera bench picture -o docs --scans FOLDER\n\n"
    "and each section says how, where and with which volumes it was made. `--only NAME` makes one section "
    "again.\n";

constexpr const char* kPapersHeading = "# Techniques of the papers\n\n"
                                       "Tessera follows four papers. The first section says where each of "
                                       "the 90 systems that they describe is in the code. The others "
                                       "measure what Tessera does otherwise, beside what it does in its "
                                       "place. This page is generated, with its figures and the CSV "
                                       "files beside it, by\n\n"
                                       "    tessera bench papers -o docs/measurements --scans FOLDER\n\n"
                                       "and each section says how, where and with which volumes it was made. "
                                       "`--only NAME` makes one section again.\n";

const Page& levelsPage() {
    static const Page page = {"level-of-detail",
                              "tessera bench lod -o FOLDER",
                              kLevelsHeading,
                              {{"hierarchy", hierarchyReport, VolumeSet::levels},
                               {"gradient", nullptr, VolumeSet::levels},
                               {"edges", edgeCostReport, VolumeSet::levels},
                               {"sampling", samplingReport, VolumeSet::levels},
                               {"skipping", skippingReport, VolumeSet::levels},
                               {"reductions", reductionsReport, VolumeSet::levels},
                               {"prediction", predictionReport, VolumeSet::levels},
                               {"occlusion", occlusionReport, VolumeSet::levels},
                               {"memory", memoryReport, VolumeSet::levels},
                               {"calibration", calibrationReport, VolumeSet::calibration}}};
    return page;
}
const Page& picturePage() {
    static const Page page = {
        "first-picture",
        "tessera bench picture -o FOLDER",
        kPictureHeading,
        {{"framing", framingReport, VolumeSet::all}, {"grain", grainReport, VolumeSet::all}}};
    return page;
}
const Page& papersPage() {
    static const Page page = {"papers",
                              "tessera bench papers -o FOLDER",
                              kPapersHeading,
                              {{"systems", systemsReport, VolumeSet::levels},
                               {"hulls", hullsReport, VolumeSet::levels},
                               {"splats", splatsReport, VolumeSet::levels},
                               {"object-order", objectOrderReport, VolumeSet::levels},
                               {"presence", presenceReport, VolumeSet::levels},
                               {"previews", previewsReport, VolumeSet::levels}}};
    return page;
}

/// Of all its experiments.
std::vector<std::string> volumesOf(const Page& page) {
    std::vector<std::string> names;
    for (const Experiment& experiment : page.experiments)
        for (const std::string& name : volumeNames(experiment.volumes))
            if (std::find(names.begin(), names.end(), name) == names.end())
                names.push_back(name);
    return names;
}

void checkNames(const std::vector<std::string>& given, const std::vector<std::string>& names,
                const std::string& option) {
    for (const std::string& name : given)
        indexOfName(name, names, option); // throws for one that is not there
}

std::string volumesLine(const Workbench& bench) {
    std::string text = "Volumes: ";
    for (const BenchVolume& volume : bench.volumes)
        text += (&volume == &bench.volumes.front() ? "" : "; ") + ("*" + volume.name + "*: ") + volume.about;
    text += ".";
    if (!bench.leftOut.empty())
        text += " Left out: " + joinNames(bench.leftOut) + ".";
    return text;
}

void runBench(const BenchArguments& arguments, const Page& page, const CommonOptions& common) {
    checkNames(arguments.only, experimentNames(page), "--only");
    checkNames(arguments.volumes, volumesOf(page), "--volumes");
    const fs::path scans = scansFolder(arguments.scans);
    const std::size_t ramBytes = budgetBytes(arguments.ram, "--ram", common);
    std::error_code error;
    fs::create_directories(arguments.out, error);
    if (error)
        throw badFile(arguments.out, "a folder to write in", error.message());
    const PagePlace place{arguments.out, page.name, page.heading, experimentNames(page)};
    const EngineKind engine = studyEngine(arguments.engine);
    checkGlDevice({arguments.device});
    const std::string drawnBy = EngineMaker(engine, {arguments.device}).about();
    const ScratchFolder scratch;
    std::map<VolumeSet, Workbench> benches;
    std::size_t withoutFigure = 0;
    std::string options = arguments.quick ? " --quick" : "";
    if (engine != EngineKind::automatic)
        options += " --engine " + arguments.engine;
    for (const std::string& volume : arguments.volumes)
        options += " --volumes " + volume;
    for (const Experiment& experiment : page.experiments) {
        const auto& only = arguments.only;
        if (!only.empty() && std::find(only.begin(), only.end(), experiment.name) == only.end())
            continue;
        Workbench* bench = nullptr;
        if (experiment.onVolumes) {
            auto made = benches.find(experiment.volumes);
            if (made == benches.end())
                made = benches
                           .emplace(experiment.volumes,
                                    makeWorkbench(engine, arguments.device, scans, experiment.volumes,
                                                  arguments.volumes, scratch.path(), arguments.quick,
                                                  ramBytes, common))
                           .first;
            bench = &made->second;
            bench->begin(experiment.name, experiment.volumes == VolumeSet::all ? 0 : bench->scenes());
        }
        constexpr unsigned kSeeds = 20;
        Report report = bench ? experiment.onVolumes(*bench) : edgeFunctionReport(kSeeds);
        if (bench)
            report.text.push_back(volumesLine(*bench));
        const MadeBy madeBy{std::string(page.command) + " --only " + experiment.name + options,
                            describeMachine(drawnBy) + "; load " + formatCell(loadAverage()),
                            TESSERA_VERSION};
        withoutFigure += writeReport(report, madeBy, place);
    }
    if (withoutFigure > 0)
        common.note(withoutFigures(withoutFigure));
    common.note("wrote " + (fs::path(arguments.out) / (std::string(page.name) + ".md")).string());
}

void addCommon(Command& command, BenchArguments& arguments, const Page& page) {
    const std::string name = page.name;
    command
        .option("-o,--output", arguments.out,
                "folder for the page " + name + ".md and the folder " + name + " beside it")
        .required();
    command.option("--scans", arguments.scans,
                   "folder with the public scans that the page names (default: $TESSERA_TEST_DATA)");
    command.option("--volumes", arguments.volumes, "only these volumes: " + joinNames(volumesOf(page)));
    command.flag("--quick", arguments.quick, "small volumes and pictures, for a quick check");
    command.option("--ram", arguments.ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    command
        .option("--engine", arguments.engine,
                "that draws: " + joinNames(studyEngineNames()) +
                    "; the skipping section is of the march in OpenGL, and the framing and calibration "
                    "sections name theirs")
        .showsDefault();
    command.option("--gl-device", arguments.device, "auto, software or a number").showsDefault();
}

} // namespace

void addBenchCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command =
        program.command("bench", "Measure first pictures and levels of detail, for the pages of docs/");
    command.needsCommand();
    command.footer("Example:\n  tessera bench lod -o results --quick");
    auto arguments = std::make_shared<BenchArguments>();
    const auto add = [&](const char* name, const char* about, const Page& page) {
        Command one = command.command(name, about);
        addCommon(one, *arguments, page);
        return one;
    };

    Command lod = add("lod", "Edge functions, sampling, reductions, predictions, budgets, promised errors",
                      levelsPage());
    lod.option("--only", arguments->only, "sections to make: " + joinNames(experimentNames(levelsPage())));
    lod.footer("Example:\n  tessera bench lod -o results --scans scans --only gradient");
    lod.whenChosen([arguments, &common, &action] {
        action = [arguments, &common] { runBench(*arguments, levelsPage(), common); };
    });

    Command memory =
        add("memory", "Budgets of GPU memory, from a scene's minimum to unlimited", levelsPage());
    memory.footer("Example:\n  tessera bench memory -o results --quick");
    memory.whenChosen([arguments, &common, &action] {
        arguments->only = {"memory"};
        action = [arguments, &common] { runBench(*arguments, levelsPage(), common); };
    });

    Command papers =
        add("papers", "Techniques of the papers beside what is done in their place", papersPage());
    papers.option("--only", arguments->only, "sections to make: " + joinNames(experimentNames(papersPage())));
    papers.footer("Example:\n  tessera bench papers -o results --scans scans --only hulls");
    papers.whenChosen([arguments, &common, &action] {
        action = [arguments, &common] { runBench(*arguments, papersPage(), common); };
    });

    Command picture = add("picture", "The fitted camera, and the smoothness of surfaces", picturePage());
    picture.option("--only", arguments->only,
                   "sections to make: " + joinNames(experimentNames(picturePage())));
    picture.footer("Example:\n  tessera bench picture -o results --scans scans --volumes abdomen");
    picture.whenChosen([arguments, &common, &action] {
        action = [arguments, &common] { runBench(*arguments, picturePage(), common); };
    });
}

} // namespace tessera
