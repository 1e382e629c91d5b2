// viewer/cli/render/one_picture.cpp: see one_picture.h.
#include "viewer/cli/render/one_picture.h"

#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/interrupt.h" // TemporaryPath
#include "core/base/names.h"
#include "core/base/output_file.h"
#include "core/image/page_format.h"
#include "render/plan/frame_plan.h"
#include "viewer/annotations/figure_file.h"
#include "viewer/annotations/figure_page.h"
#include "viewer/annotations/figure_part.h"
#include "viewer/cli/input/further_volumes.h"
#include "viewer/cli/manifest/manifest.h"
#include "viewer/cli/render/asked_options.h"
#include "viewer/cli/render/kept_state.h"
#include "viewer/cli/render/picture_files.h"
#include "viewer/cli/render/picture_notes.h"
#include "viewer/cli/render/ranked_picture.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <glm/vector_relational.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <unistd.h>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// The manifest of a coarse first picture. It tells a leftover of a killed process from a user's file.
constexpr const char* kFirstManifest = R"({"tesseraFirstPicture":1,"notice":"not for diagnosis"})";
bool isFirstPicture(const fs::path& path) {
    try {
        return manifestOf(path) == kFirstManifest;
    } catch (const Error&) {
        return false;
    }
}

/// True for pictures that take so long, and whose coarse version takes so much less, that a coarse first
/// picture is worth its time.
bool isLarge(const VolumeInfo& info, const Scene& scene) {
    constexpr int kVoxels = 256, kPixels = 256 * 256; // at fewer there is little to wait for
    return glm::any(glm::greaterThan(info.extentVoxels, glm::ivec3(kVoxels))) &&
           scene.imageSize.x * scene.imageSize.y >= kPixels;
}

/// From the system's own account of when this process began: loading the program counts too.
double secondsSinceProcessStart() {
    std::ifstream stat("/proc/self/stat");
    std::string text((std::istreambuf_iterator<char>(stat)), {});
    std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
    std::string field;
    for (int i = 3; i <= 22 && fields >> field; ++i)
        ; // field 22: start, in clock ticks since the system's
    timespec now{};
    clock_gettime(CLOCK_BOOTTIME, &now);
    const double start = std::strtod(field.c_str(), nullptr) / static_cast<double>(sysconf(_SC_CLK_TCK));
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec) - start;
}

/// The scene by the preview of a store behind an address, whose own bytes come slowly. None: there is no such
/// store, or no preview that can be drawn.
std::optional<Image> pictureOfPreview(const RenderTask& task) {
    const std::filesystem::path place = task.store.path() / kPreviewFolder;
    if (!isAddress(task.store.path()) || task.stores.size() > 1 || task.scene.lighting.transport ||
        !isStore(place))
        return std::nullopt;
    try {
        const StoreReader preview(place, task.ram, task.scene.volumes.front().transform);
        RenderOptions options = task.options;
        options.verify = Verify::none;
        options.searching = options.checking = false;
        const StoreReader* const stores[] = {&preview};
        return renderScene(firstScene(task.scene), stores, task.ram, task.gpu, options).image;
    } catch (const InputError& e) {
        task.common.detail("the store's preview was not drawn: " + std::string(e.what()));
        return std::nullopt;
    }
}

} // namespace

/// A file that goes when the command ends, however it ends.
class FirstPicture::PassingFile {
  public:
    explicit PassingFile(const fs::path& path) : path_(path), unfinished_(path) {}
    ~PassingFile() {
        std::error_code ignored;
        fs::remove(path_, ignored);
    }
    PassingFile(const PassingFile&) = delete;
    PassingFile& operator=(const PassingFile&) = delete;

  private:
    fs::path path_;
    TemporaryPath unfinished_;
};

FirstPicture::FirstPicture(const RenderTask& task) : task_(task), path_(task.arguments.first) {
    const EngineKind engine = task.options.engine;
    const bool drawsFirst = engine == EngineKind::automatic || traitsOf(engine).quick;
    if (wanted() && !drawsFirst)
        throw badFile("--first", "--engine " + joinNames(engineNames(true)), task.arguments.engine);
    if (wanted() || !drawsFirst || task.options.group || task.take || !task.common.progress->watched() ||
        !isLarge(task.store.info(), task.scene))
        return;
    const fs::path out = task.arguments.out;
    const std::string ending = pageFormat(out) ? ".png" : out.extension().string();
    path_ = fs::path(out).replace_extension(".first" + ending);
    std::error_code ignored;
    if (fs::exists(path_, ignored) && !isFirstPicture(path_))
        path_.clear(); // a user's file
    else
        passing_ = std::make_unique<PassingFile>(path_);
}

FirstPicture::~FirstPicture() = default;

void FirstPicture::write(const Image& image, double secondsLeft) {
    const Charge charge =
        task_.ram.charge(kPictureBytesPerPixel * image.pixels.size() / 2, "the first picture");
    writePicture(path_, image, task_.scene.background, passing_ ? kFirstManifest : "{}");
    seconds_ = secondsSinceProcessStart();
    const std::string left =
        secondsLeft > 0 ? "; the picture takes about " + formatNumber(std::ceil(secondsLeft), 2) + " s more"
                        : "";
    task_.common.note("wrote " + path_.string() + ", coarse, after " + formatNumber(seconds_, 3) + " s" +
                      left);
}

namespace {

/// With the strips of the task, if it has some.
Figure figureOfResult(const RenderTask& task, const RenderResult& result) {
    FigurePart part =
        FigureMaker(task.scene, task.stores, task.ram, task.options.threads).part(task.scene, result);
    const double dpi = task.scene.annotations.dpi;
    return task.strips ? figureOf(std::move(part), dpi, *task.strips) : figureOf(std::move(part), dpi);
}

} // namespace

void renderOnePicture(const RenderTask& task) {
    const RenderArguments& arguments = task.arguments;
    const CommonOptions& common = task.common;
    FirstPicture first(task);
    RenderOptions options = task.options;
    options.progress = common.progress.get();
    if (const auto quick = first.wanted() ? pictureOfPreview(task) : std::nullopt)
        first.write(*quick, 0);
    else if (first.wanted())
        options.onFirstPicture = [&](const Image& image, double secondsLeft) {
            first.write(image, secondsLeft);
        };
    const std::unique_ptr<KeptSamples> kept = keptStateOf(task);
    options.kept = kept.get();
    RenderResult result = renderScene(task.scene, task.stores, task.ram, task.gpu, options);
    nlohmann::json ranks;
    if (options.group) {
        ranks = ranksJson(task, result);
        if (options.group->rank() > 0)
            return;
    }
    if (arguments.keys.textOf("--fetch") == "hardware" && !traitsOf(result.engine).onContext)
        common.note("--fetch hardware: the " + name(result.engine) + " engine fetches exactly");
    if (result.takenAsHu)
        common.note(
            "the values have no unit, but look like HU (air near -1000): taken as HU; --unit HU confirms it");
    noteTable(task, result);
    noteLeftOut(task, result);
    noteMirrored(task);
    if (result.pixels.ofEarlierRuns > 0)
        common.note("went on from " + std::to_string(result.pixels.ofEarlierRuns) + " samples a pixel of " +
                    arguments.keepState);
    const std::vector<LayerChannel> layers = channelsOf(task.layers, result);
    const std::size_t ofLayers = (result.layers ? PictureLayers::kPictures * sizeof(glm::vec4) : 0) +
                                 (result.pixelErrors ? sizeof(glm::vec4) : 0);
    const Charge pictures =
        task.ram.charge((kPictureBytesPerPixel + ofLayers) * result.image.pixels.size(), "the picture");

    if (!task.take)
        common.progress->stage("writing the picture");
    nlohmann::json report = makeManifest(task.scene, task.stores, result, task.ram, task.gpu);
    if (options.group)
        report["ranks"] = ranks;
    const bool blank = isBlank(result.image);
    const Figure figure = figureOfResult(task, result);
    tellAnnotations(report, figure);
    if (task.layers.any())
        report["layers"] = task.layers.names();
    report["options"] = optionsJson(task);
    if (task.take) {
        task.take(task, result, figure, report);
    } else {
        if (task.scene.background)
            result.image = overBackground(result.image, *task.scene.background);
        writeFigure(arguments.out, std::move(result.image), figure, manifestText(report), layers, task.ram);
    }

    common.progress->end();
    if (const std::string words = leftOutText(report); !words.empty())
        common.note(words);
    if (blank)
        warnBlank(task, result);
    std::vector<std::string> lines;
    if (arguments.explain) {
        lines = explain(result, task.scene);
        for (std::string& line : damageLines(task.stores))
            lines.push_back(std::move(line));
    }
    if (arguments.json) {
        report["output"] = arguments.out;
        report["blank"] = blank;
        report["seconds"] = {{"preparing", result.secondsPreparing},
                             {"loading", result.secondsLoading},
                             {"drawing", result.secondsDrawing},
                             {"checking", result.secondsChecking}};
        if (first.seconds() > 0)
            report["seconds"]["firstPictureSinceStart"] = first.seconds();
        if (arguments.explain)
            report["explain"] = lines;
        printReport(report);
    } else {
        for (const std::string& line : lines)
            std::printf("%s\n", line.c_str());
    }
    if (!task.take)
        finishStandardOutput();
    if (!blank)
        noteMissingSurfaces(task, result);
    noteUnseenSky(task);
    noteMissedError(task, result);
    if (!task.take)
        noteWritten(task, task.scene, result, "");
    common.detail("most charged: RAM " + formatBytes(task.ram.peakBytes()) + " of " +
                  formatBytes(task.ram.limitBytes()) + ", GPU memory " + formatBytes(task.gpu.peakBytes()) +
                  " of " + formatBytes(task.gpu.limitBytes()));
}

} // namespace tessera
