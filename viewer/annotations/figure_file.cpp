// viewer/annotations/figure_file.cpp: see figure_file.h.
#include "viewer/annotations/figure_file.h"

#include "core/base/error.h"
#include "core/image/page_format.h"
#include "viewer/annotations/figure_drawing.h"
#include "viewer/annotations/figure_layout.h" // kScaleBarWords
#include "viewer/annotations/figure_page.h"
#include "viewer/cli/manifest/manifest.h" // scaleBarJson, legendJson
#if TESSERA_WITH_IMAGE_FILES
#include "core/image/image_file.h"
#endif

#include <algorithm>
#include <cstddef>
#include <glm/vec4.hpp>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

#if !TESSERA_WITH_ANNOTATIONS
// In place of the module.

DrawingReport describeDrawing(const Figure&) {
    throw InputError("annotations: this program was built without them");
}
StripHeights measureStrips(const FigurePart&, double) {
    throw InputError("annotations: this program was built without them");
}
Strips measureBeside(const FigurePart&, double) {
    throw InputError("annotations: this program was built without them");
}
void drawAnnotations(const Figure&, Image&) {
    throw InputError("annotations: this program was built without them");
}
DrawRows annotationRows(const Figure&) {
    throw InputError("annotations: this program was built without them");
}
void writePage(const std::filesystem::path& path, const Image&, const Figure&, const std::string&,
               MemoryBudget&) {
    throw InputError(path.string() + ": this program was built without PDF and SVG");
}
#endif

namespace {

#if !TESSERA_WITH_IMAGE_FILES
void writeImage(const std::filesystem::path& path, const Image&, const std::string&,
                std::span<const LayerChannel> = {}, double = 0) {
    throw InputError(path.string() + ": this program was built without picture files");
}
struct LayerRows {
    std::string name;
    ImageRows picture;
};
void writeImageRows(const std::filesystem::path& path, const ImageRows&, const std::string&, double,
                    const LayerRows* = nullptr) {
    throw InputError(path.string() + ": this program was built without picture files");
}
#endif

double dpiOf(const Figure& figure) {
    return figure.any() || figure.dpi != Annotations().dpi ? figure.dpi : 0;
}

void writeLayered(const std::filesystem::path& path, const Image& picture, const Figure& figure,
                  const std::string& manifest, std::span<const LayerChannel> layers, MemoryBudget& ram) {
    const Charge charge = ram.charge(sizeof(glm::vec4) * picture.pixels.size(), "the layer of annotations");
    Image over(picture.size);
    drawAnnotations(figure, over);
    std::vector<LayerChannel> all(layers.begin(), layers.end());
    for (const auto& [name, channel] :
         {std::pair{"annotations.R", 0}, {"annotations.G", 1}, {"annotations.B", 2}, {"annotations.A", 3}})
        all.push_back({name, &over.pixels[0][channel], 4});
    writeImage(path, picture, manifest, all);
}

/// Rows that change what they get in memory of their own.
class ChangedRows {
  public:
    explicit ChangedRows(DrawRows draw) : draw_(std::move(draw)) {}
    /// Over a picture's rows.
    std::span<const glm::vec4> over(const ImageRows& picture, int first, int count) {
        const std::span<const glm::vec4> rows = picture.rows(first, count);
        rows_.assign(rows.begin(), rows.end());
        draw_(first, rows_);
        return rows_;
    }
    /// Alone.
    std::span<const glm::vec4> alone(int width, int first, int count) {
        rows_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(count), glm::vec4(0));
        draw_(first, rows_);
        return rows_;
    }

  private:
    DrawRows draw_;
    std::vector<glm::vec4> rows_;
};

} // namespace

void checkFigurePath(const std::filesystem::path& path) {
#if TESSERA_WITH_ANNOTATIONS
    checkPictureOrPage(path);
#else
    pictureFormat(path);
#endif
}

void checkAnnotations(const Scene& scene) {
    const Annotations& asked = scene.annotations;
#if !TESSERA_WITH_ANNOTATIONS
    if (asked.any())
        throw InputError(firstAnnotation(asked) + ": this program was built without annotations");
#endif
    if (asked.labelLegend && std::all_of(scene.volumes.begin(), scene.volumes.end(),
                                         [](const auto& volume) { return volume.labels.path.empty(); }))
        throw badFile("--label-legend", "a scene with labels (--labels)", "one without");
    if (asked.measurements && scene.measurements.empty())
        throw badFile("--measurements", "a scene with measurements", "one without");
    if (asked.legend && (scene.mode == Mode::isosurface || reductionOf(scene) == Reduction::sum))
        throw badFile("--legend", "a mode that shows colours or greys of values",
                      scene.mode == Mode::isosurface ? "isosurface" : "sums along rays");
}

void tellAnnotations(nlohmann::json& manifest, const Figure& figure) {
    if (!figure.any())
        return;
    const DrawingReport report = describeDrawing(figure);
    nlohmann::json fonts = nlohmann::json::array();
    for (const DrawingReport::Font& font : report.fonts)
        fonts.push_back({{"family", font.family}, {"file", font.file}});
    nlohmann::json& told = manifest["annotations"];
    told = {{"cairo", report.cairo}, {"pango", report.pango}, {"dpi", figure.dpi}, {"fonts", fonts}};
    if (!report.leftOut.empty())
        told["leftOut"] = report.leftOut;
    if (figure.parts.size() != 1)
        return;
    const FigurePart& part = figure.parts.front();
    if (part.strips.any()) {
        told["pageSize"] = {figure.size.x, figure.size.y};
        told["pictureAt"] = {part.from.x, part.from.y};
    }
    if (part.annotations.scaleBar && !std::ranges::count(report.leftOut, kScaleBarWords))
        manifest["scaleBar"] = scaleBarJson(scaleBarOf(part.camera, part.size));
    if (part.annotations.legend)
        manifest["legend"] = legendJson(part.legend);
}

std::string leftOutText(const nlohmann::json& manifest) {
    const auto told = manifest.find("annotations");
    if (told == manifest.end() || !told->contains("leftOut"))
        return {};
    std::string text;
    for (const nlohmann::json& what : told->at("leftOut"))
        text += (text.empty() ? "not in the picture: " : "; ") + what.get<std::string>();
    return text;
}

StripHeights heightsOf(const FigurePart& words, double dpi) {
    return words.annotations.title.empty() && words.annotations.caption.empty() ? StripHeights()
                                                                                : measureStrips(words, dpi);
}

void annotate(Image& picture, const Figure& figure) {
    picture = onPage(std::move(picture), figure);
    if (figure.any())
        drawAnnotations(figure, picture);
}

void writeFigure(const std::filesystem::path& path, Image picture, const Figure& figure,
                 const std::string& manifest, std::span<const LayerChannel> layers, MemoryBudget& ram) {
    if (const std::size_t bytes = pageBytes(figure); bytes > 0 && picture.size != figure.size) {
        // What is encoded of it takes as much again.
        const std::size_t pixels = bytes / sizeof(glm::vec4);
        const Charge charge =
            ram.charge(2 * bytes + layers.size() * sizeof(float) * pixels, "the picture with its strips");
        std::vector<std::vector<float>> values(layers.size());
        std::vector<LayerChannel> channels;
        for (std::size_t n = 0; n < layers.size(); ++n)
            channels.push_back(onPage(layers[n], figure, values[n]));
        Image page = onPage(std::move(picture), figure);
        return writeFigure(path, std::move(page), figure, manifest, channels, ram);
    }
    if (pageFormat(path))
        return writePage(path, picture, figure, manifest, ram);
    if (figure.any() && pictureFormat(path) == PictureFormat::exr)
        return writeLayered(path, picture, figure, manifest, layers, ram);
    annotate(picture, figure);
    writeImage(path, picture, manifest, layers, dpiOf(figure));
}

void writeFigureRows(const std::filesystem::path& path, const ImageRows& given, const Figure& figure,
                     const std::string& manifest, MemoryBudget& ram) {
    if (!figure.any())
        return writeImageRows(path, given, manifest, dpiOf(figure));
    const Charge charge =
        ram.charge(2 * sizeof(glm::vec4) * ImageRows::kAtOnce * static_cast<std::size_t>(figure.size.x),
                   "rows of annotations");
    const ImageRows picture = onPage(given, figure);
    ChangedRows rows(annotationRows(figure));
    if (pictureFormat(path) == PictureFormat::exr) {
        const LayerRows layer{"annotations", {picture.size, false, [&](int first, int count) {
                                                  return rows.alone(picture.size.x, first, count);
                                              }}};
        return writeImageRows(path, picture, manifest, 0, &layer);
    }
    const ImageRows annotated{picture.size, picture.opaque,
                              [&](int first, int count) { return rows.over(picture, first, count); }};
    writeImageRows(path, annotated, manifest, dpiOf(figure));
}

} // namespace tessera
