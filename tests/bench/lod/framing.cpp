// tests/bench/lod/framing.cpp: the experiment "framing": every volume, every preset that suits it and six
// views, fitted to the volume's box and to what is shown.
#include "tests/bench/lod/framing.h"

#include "render/picture/render_scene.h"
#include "tests/bench/lod/experiments.h"

#include <algorithm>
#include <array>

namespace tessera::bench {

Framing framingOf(const Image& image) {
    glm::ivec2 low = image.size, high(-1);
    Framing framing;
    std::size_t shown = 0, n = 0;
    for (int y = 0; y < image.size.y; ++y)
        for (int x = 0; x < image.size.x; ++x, ++n) {
            if (!(image.pixels[n].a > kShownOpacity))
                continue;
            const glm::ivec2 at(x, y);
            low = glm::min(low, at);
            high = glm::max(high, at);
            ++shown;
            framing.cutOff += x == 0 || y == 0 || x + 1 == image.size.x || y + 1 == image.size.y;
        }
    if (shown == 0)
        return framing;
    const glm::dvec2 box = glm::dvec2(high - low + 1) / glm::dvec2(image.size);
    framing.span = std::max(box.x, box.y);
    framing.share = static_cast<double>(shown) / static_cast<double>(image.pixels.size());
    return framing;
}

namespace {

/// Of all pictures of a volume under one preset.
struct Worst {
    double span = 1, leastShare = 1, mostShare = 0;
    int cutOff = 0;
    void take(const Framing& f) {
        span = std::min(span, f.span);
        leastShare = std::min(leastShare, f.share);
        mostShare = std::max(mostShare, f.share);
        cutOff = std::max(cutOff, f.cutOff);
    }
};

bool suits(const std::string& preset, const VolumeInfo& info) {
    return preset == "auto" || info.unit == "HU";
}

/// Pairs of a volume and a preset.
std::size_t scenesOf(const Workbench& bench) {
    std::size_t count = 0;
    for (const BenchVolume& volume : bench.volumes) {
        MemoryBudget ram("RAM", "--ram", bench.ramBytes);
        const StoreReader store(volume.store, ram);
        for (const std::string& preset : presetNames())
            count += suits(preset, store.info());
    }
    return count;
}

} // namespace

Report framingReport(const Workbench& bench) {
    Report report;
    report.name = "framing";
    report.title = "What fills the picture";
    const std::string pixels = std::to_string(bench.pixels());
    report.text = {"Every volume, every preset that suits its values (presets of HU for scans in HU, `auto` "
                   "for all), six views, " +
                   pixels + " x " + pixels +
                   " pixels, as `tessera render` draws them but for estimated errors: with `--fit volume`, "
                   "and with `--fit shown`, "
                   "the default. *Span*: the box around all pixels of an opacity above 0.02, the larger of "
                   "its shares of the "
                   "picture's width and height, the smallest of six views. *Share*: of the pixels that show "
                   "something, from the "
                   "least to the most of six views. *Cut off*: pixels at the border that show something, the "
                   "most of six views."};
    Table all{"framing-views",
              "",
              {"volume", "preset", "view", "span volume", "span shown", "share volume", "share shown",
               "cut off volume", "cut off shown"},
              {},
              false};
    Table table{"framing",
                "By volume and preset:",
                {"volume", "preset", "span, volume", "span, shown", "share, volume", "share, shown",
                 "cut off, volume", "cut off, shown"},
                {},
                true};
    double least = 1;
    int most = 0, pictures = 0, blank = 0;
    bench.expect(scenesOf(bench));
    for (const BenchVolume& volume : bench.volumes) {
        MemoryBudget ram("RAM", "--ram", bench.ramBytes);
        const StoreReader store(volume.store, ram);
        for (const std::string& preset : presetNames()) {
            if (!suits(preset, store.info()))
                continue;
            std::array<Worst, 2> worst;
            for (std::size_t v = 0; v < viewNames().size(); ++v) {
                std::array<Framing, 2> framing;
                for (const Fit fit : {Fit::volume, Fit::shown}) {
                    Scene scene;
                    scene.volumes = {{volume.store, preset}};
                    scene.imageSize = glm::ivec2(bench.pixels());
                    scene.camera = FittedView{static_cast<View>(v), Projection::perspective, fit};
                    MemoryBudget gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
                    RenderOptions options;
                    options.engine = bench.engine;
                    options.device.text = bench.device;
                    options.counting = false;
                    framing[static_cast<std::size_t>(fit)] =
                        framingOf(renderScene(scene, store, ram, gpu, options).image);
                }
                const Framing& shown = framing[static_cast<std::size_t>(Fit::shown)];
                const Framing& box = framing[static_cast<std::size_t>(Fit::volume)];
                all.rows.push_back({volume.name, preset, viewNames()[v], box.span, shown.span, box.share,
                                    shown.share, double(box.cutOff), double(shown.cutOff)});
                if (shown.share == 0) {
                    ++blank;
                    continue;
                }
                ++pictures;
                for (const Fit fit : {Fit::volume, Fit::shown})
                    worst[static_cast<std::size_t>(fit)].take(framing[static_cast<std::size_t>(fit)]);
            }
            const Worst& shown = worst[static_cast<std::size_t>(Fit::shown)];
            const Worst& box = worst[static_cast<std::size_t>(Fit::volume)];
            if (shown.mostShare == 0)
                continue;
            const auto range = [](const Worst& w) {
                return formatCell(w.leastShare) + " to " + formatCell(w.mostShare);
            };
            table.rows.push_back({volume.name, preset, box.span, shown.span, range(box), range(shown),
                                  double(box.cutOff), double(shown.cutOff)});
            least = std::min(least, shown.span);
            most = std::max(most, shown.cutOff);
            bench.done(volume.name + ", " + preset);
        }
    }
    report.tables = {std::move(table), std::move(all)};
    report.after = {"Of " + std::to_string(pictures) +
                    " pictures fitted to what is shown, the smallest span is " + formatCell(least) +
                    ", and " + std::to_string(most) + " pixels of the worst one are cut off at the border. " +
                    (blank > 0
                         ? std::to_string(blank) + " pictures more show nothing by either fit: no value of "
                                                   "the volume is visible under the preset."
                         : std::string())};
    return report;
}

} // namespace tessera::bench
