// viewer/cli/render/one_picture.cpp: see one_picture.h.
#include "viewer/cli/render/one_picture.h"

#include "core/base/output_file.h"
#include "viewer/cli/manifest/manifest.h"
#include "viewer/cli/render/first_picture.h"
#include "viewer/cli/render/picture_files.h"
#include "viewer/cli/render/picture_notes.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace tessera {

void renderOnePicture(const RenderTask& task) {
    const RenderArguments& arguments = task.arguments;
    const CommonOptions& common = task.common;
    FirstPicture first(task);
    RenderOptions options = task.options;
    options.progress = common.progress.get();
    if (first.wanted())
        options.onFirstPicture = [&](const Image& image, double secondsLeft) {
            first.write(image, secondsLeft);
        };
    RenderResult result = renderScene(task.scene, task.store, task.ram, task.gpu, options);
    if (arguments.keys.textOf("--fetch") == "hardware" && !traitsOf(result.engine).onContext)
        common.note("--fetch hardware: the " + name(result.engine) + " engine fetches exactly");
    if (result.takenAsHu)
        common.note(
            "the values have no unit, but look like HU (air near -1000): taken as HU; --unit HU confirms it");
    const Charge pictures =
        task.ram.charge(kPictureBytesPerPixel * result.image.pixels.size(), "the picture");

    common.progress->stage("writing the picture");
    nlohmann::json report = makeManifest(task.scene, task.store, result, task.ram, task.gpu);
    const bool blank = isBlank(result.image); // judged before the scale bar is drawn
    if (arguments.scaleBar) {
        const ScaleBar bar = scaleBarOf(result.camera, result.image.size);
        drawScaleBar(result.image, bar);
        report["scaleBar"] = scaleBarJson(bar);
    }
    writePicture(arguments.out, result.image, task.scene.background, manifestText(report));

    common.progress->end();
    if (blank)
        warnBlank(task, result);
    const std::vector<std::string> lines =
        arguments.explain ? explain(result, task.scene) : std::vector<std::string>();
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
    finishStandardOutput();
    if (!blank)
        noteMissingSurfaces(task, result);
    noteMissedError(task, result);
    noteWritten(task, task.scene, result, "");
    common.detail("most charged: RAM " + formatBytes(task.ram.peakBytes()) + " of " +
                  formatBytes(task.ram.limitBytes()) + ", GPU memory " + formatBytes(task.gpu.peakBytes()) +
                  " of " + formatBytes(task.gpu.limitBytes()));
}

} // namespace tessera
