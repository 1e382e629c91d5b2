// viewer/session/shown_picture.cpp: see shown_picture.h.
#include "viewer/session/shown_picture.h"

#include "core/base/error.h"
#include "core/base/threads.h"
#include "core/image/colour.h"
#include "core/scene/scene.h"
#if TESSERA_WITH_IMAGE_FILES
#include "render/contract/ray_state.h" // rayCount
#include "render/plan/frame_plan.h"    // kPictureBytesPerPixel
#include "viewer/annotations/figure.h"
#include "viewer/annotations/figure_file.h"
#include "viewer/annotations/figure_page.h"
#include "viewer/annotations/panel_sheet.h"
#include "viewer/cli/manifest/manifest.h" // manifestText

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec4.hpp>

namespace tessera {
namespace {

constexpr int kRowsAtATime = 16;
constexpr glm::vec3 kGrey{0.014f};

/// The 8-bit code of a linear value, as files have it, by its thresholds.
class Codes {
  public:
    Codes() {
        for (int code = 1; code < 256; ++code) {
            float& least = least_[static_cast<std::size_t>(code)];
            least = static_cast<float>(linearFromSrgb((code - 0.5) / 255));
            while (codeOf(least) >= code)
                least = std::nextafter(least, 0.0f);
            while (codeOf(least) < code)
                least = std::nextafter(least, 2.0f);
        }
        least_[256] = 2;
        int code = 0;
        for (std::size_t i = 0; i < kGuesses; ++i) {
            while (static_cast<float>(i) / (kGuesses - 1) >= least_[static_cast<std::size_t>(code + 1)])
                ++code;
            guess_[i] = static_cast<std::uint8_t>(code);
        }
    }
    std::uint32_t operator()(float linear) const {
        const float v = linear >= 0 ? std::min(linear, 1.0f) : 0.0f; // NaN is 0
        std::uint32_t code = guess_[static_cast<std::size_t>(v * (kGuesses - 1))];
        while (v >= least_[code + 1])
            ++code;
        return code;
    }

  private:
    static constexpr std::size_t kGuesses = 4096;
    static int codeOf(float linear) {
        return static_cast<int>(std::lround(srgbFromLinear(static_cast<double>(linear)) * 255));
    }
    std::array<float, 257> least_{}; // linear value that a code begins at
    std::array<std::uint8_t, kGuesses> guess_{};
};

/// The position of a pixel of the larger picture in the smaller one: the first of four pixels, and their
/// weights.
struct Taps {
    int first = 0;
    std::array<float, 4> weight{};
};

std::vector<Taps> tapsFor(int from, int to) {
    std::vector<Taps> taps(static_cast<std::size_t>(to));
    for (int i = 0; i < to; ++i) {
        const double at = (i + 0.5) * from / to - 0.5, low = std::floor(at);
        const auto f = static_cast<float>(at - low);
        Taps& t = taps[static_cast<std::size_t>(i)];
        t.first = static_cast<int>(low) - 1;
        t.weight = {f * (-0.5f + f * (1 - 0.5f * f)), 1 + f * f * (-2.5f + 1.5f * f),
                    f * (0.5f + f * (2 - 1.5f * f)), f * f * (-0.5f + 0.5f * f)};
    }
    return taps;
}

/// A row of the smaller picture as high as the larger one: what was interpolated, and the two rows around it.
struct WideRow {
    std::vector<glm::vec4> value, low, high;
    explicit WideRow(int width)
        : value(static_cast<std::size_t>(width)), low(value.size()), high(value.size()) {}

    void interpolate(const Image& image, const Taps& t) {
        const auto row = [&](int k) { return std::clamp(t.first + k, 0, image.size.y - 1); };
        for (int x = 0; x < image.size.x; ++x) {
            const glm::vec4 &a = image.at(x, row(0)), &b = image.at(x, row(1)), &c = image.at(x, row(2)),
                            &d = image.at(x, row(3));
            const auto i = static_cast<std::size_t>(x);
            value[i] = t.weight[0] * a + t.weight[1] * b + t.weight[2] * c + t.weight[3] * d;
            low[i] = glm::min(b, c), high[i] = glm::max(b, c);
        }
    }
    glm::vec4 at(const Taps& t, int width) const {
        const auto column = [&](int k) {
            return static_cast<std::size_t>(std::clamp(t.first + k, 0, width - 1));
        };
        const std::size_t b = column(1), c = column(2);
        const glm::vec4 sum = t.weight[0] * value[column(0)] + t.weight[1] * value[b] +
                              t.weight[2] * value[c] + t.weight[3] * value[column(3)];
        return glm::clamp(sum, glm::min(low[b], low[c]), glm::max(high[b], high[c]));
    }
};

} // namespace

std::vector<std::uint32_t> displayPixels(const Image& image, const std::optional<glm::vec3>& background,
                                         const glm::ivec2& size, int threads) {
    static const Codes codes;
    TESSERA_CHECK(image.size.x > 0 && image.size.y > 0 && size.x >= image.size.x && size.y >= image.size.y);
    const glm::vec3 behind = background.value_or(kGrey);
    const auto width = static_cast<std::size_t>(size.x);
    std::vector<std::uint32_t> out(width * static_cast<std::size_t>(size.y));
    const auto shown = [&](const glm::vec4& c) {
        const glm::vec3 rgb = glm::vec3(c) + (1 - c.a) * behind;
        return codes(rgb.r) | codes(rgb.g) << 8 | codes(rgb.b) << 16 | 0xFF000000u;
    };
    const bool larger = size != image.size;
    const std::vector<Taps> columns = larger ? tapsFor(image.size.x, size.x) : std::vector<Taps>(),
                            rows = larger ? tapsFor(image.size.y, size.y) : std::vector<Taps>();
    const int strips = (size.y + kRowsAtATime - 1) / kRowsAtATime;
    parallelFor(static_cast<std::size_t>(strips), threads, [&](std::size_t strip) {
        const int first = static_cast<int>(strip) * kRowsAtATime,
                  end = std::min(first + kRowsAtATime, size.y);
        WideRow row(larger ? image.size.x : 0);
        for (int y = first; y < end; ++y) {
            std::uint32_t* const to = &out[static_cast<std::size_t>(y) * width];
            if (!larger) {
                for (int x = 0; x < size.x; ++x)
                    to[x] = shown(image.at(x, y));
                continue;
            }
            row.interpolate(image, rows[static_cast<std::size_t>(y)]);
            for (int x = 0; x < size.x; ++x)
                to[x] = shown(row.at(columns[static_cast<std::size_t>(x)], image.size.x));
        }
    });
    return out;
}

#if TESSERA_WITH_IMAGE_FILES
namespace {

/// Of a picture, or of what stands for it.
nlohmann::json manifestOf(const ShownPicture& picture) {
    if (!picture.manifest.empty())
        return nlohmann::json::parse(picture.manifest);
    nlohmann::json coarse = {{"notice", "not for diagnosis"}, {"coarse", true}};
    if (const auto& samples = picture.samples) { // of a still that is not done
        coarse["samples"] = samples->taken;
        if (samples->noise)
            coarse["noise"] = *samples->noise;
    }
    return coarse;
}

FigurePart partOf(const SavedPanel& panel) {
    FigurePart part = panel.marks;
    part.from = {0, 0};
    part.size = panel.picture->image.size;
    part.camera = panel.picture->camera;
    const auto& background = panel.picture->background;
    part.onLight = isLight(background);
    const auto& strips = part.annotations.marginColour ? part.annotations.marginColour : background;
    part.stripColour = strips ? glm::vec4(*strips, 1) : glm::vec4(0);
    part.stripsAreLight = isLight(strips);
    for (std::size_t n = 0; n < part.legend.size(); ++n) // names of files may be those of patients
        part.legend[n].name = part.legend.size() > 1 ? "volume " + std::to_string(n + 1) : "";
    return part;
}

/// Makes the manifest's scene have what is drawn into the picture, so that it is drawn again: a window adds
/// to the annotations of the scene that it drew.
void tellDrawn(nlohmann::json& manifest, const FigurePart& part) {
    if (!manifest.contains("scene"))
        return; // a picture that is not drawn again
    Scene scene;
    scene.volumes.resize(1);
    scene.annotations = part.annotations;
    scene.measurements = part.measurements;
    const nlohmann::json drawn = nlohmann::json::parse(sceneJson(scene));
    for (const char* const key : {"annotations", "measurements"}) {
        manifest["scene"].erase(key);
        if (drawn.contains(key))
            manifest["scene"][key] = drawn[key];
    }
}

/// A picture on its background, and what is encoded of it.
Charge chargeFor(const glm::ivec2& size, MemoryBudget& ram) {
    return ram.charge((kPictureBytesPerPixel - sizeof(glm::vec4)) * rayCount(size), "the saved picture");
}

void savePicture(const std::filesystem::path& path, const SavedPanel& panel, MemoryBudget& ram) {
    const ShownPicture& picture = *panel.picture;
    const Charge charge = chargeFor(picture.image.size, ram);
    Image image = picture.background ? overBackground(picture.image, *picture.background) : picture.image;
    const Figure figure = figureOf(partOf(panel), panel.marks.annotations.dpi);
    nlohmann::json manifest = manifestOf(picture);
    tellDrawn(manifest, figure.parts.front());
    tellAnnotations(manifest, figure);
    writeFigure(path, std::move(image), figure, manifestText(manifest), {}, ram);
}

} // namespace

void savePictures(const std::filesystem::path& path, const std::vector<SavedPanel>& panels,
                  MemoryBudget& ram) {
    constexpr int kGap = 8; // as of --gap
    checkFigurePath(path);
    if (panels.size() == 1)
        return savePicture(path, panels.front(), ram);
    const glm::ivec2 size = panels.front().picture->image.size;
    std::vector<FigurePart> parts;
    std::vector<Annotations*> words;
    for (const SavedPanel& panel : panels) {
        if (const glm::ivec2 other = panel.picture->image.size; other != size)
            throw badFile(path.string(), "pictures of one size, as they are at rest",
                          std::to_string(size.x) + " x " + std::to_string(size.y) + " and " +
                              std::to_string(other.x) + " x " + std::to_string(other.y));
        parts.push_back(partOf(panel));
    }
    for (FigurePart& part : parts)
        words.push_back(&part.annotations);
    PanelLayout layout;
    layout.words = takeShared(words);
    layout.oneScale = false; // cameras are as they are
    const auto count = static_cast<int>(panels.size());
    layout.grid = gridOf(count, count, kGap, size, path.string());
    for (const FigurePart& part : parts)
        layout.grid.strips = larger(layout.grid.strips, stripsOf(part, part.annotations.dpi));
    makeRoomForWords(layout, path.string());
    const Charge charge = chargeFor(layout.grid.size(), ram);
    PanelSheet sheet(layout);
    for (std::size_t n = 0; n < panels.size(); ++n) {
        const ShownPicture& picture = *panels[n].picture;
        nlohmann::json manifest = manifestOf(picture);
        tellDrawn(manifest, parts[n]);
        sheet.put(picture.image, std::move(parts[n]), picture.background, std::move(manifest));
    }
    sheet.write(path, ram);
}
#else
void savePictures(const std::filesystem::path& path, const std::vector<SavedPanel>&, MemoryBudget&) {
    throw InputError(path.string() + ": this program was built without picture files");
}
#endif

} // namespace tessera
