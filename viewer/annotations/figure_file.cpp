// viewer/annotations/figure_file.cpp: see figure_file.h.
#include "viewer/annotations/figure_file.h"

#include "core/base/error.h"
#include "core/image/image_file.h"
#if TESSERA_WITH_ANNOTATIONS
#include "viewer/annotations/figure_drawing.h"
#endif

#include <nlohmann/json.hpp>
#include <vector>

namespace tessera {

#if TESSERA_WITH_ANNOTATIONS

namespace {

constexpr double kUsualDpi = Annotations().dpi;

double dpiOf(const Figure& figure) {
    return figure.any() || figure.dpi != kUsualDpi ? figure.dpi : 0;
}

void writeExr(const std::filesystem::path& path, const Image& picture, const Figure& figure,
              const std::string& manifest, std::span<const LayerChannel> layers, MemoryBudget& ram) {
    const Charge charge = ram.charge(sizeof(glm::vec4) * picture.pixels.size(), "the layer of annotations");
    Image over(picture.size);
    drawAnnotations(figure, over);
    std::vector<LayerChannel> all(layers.begin(), layers.end());
    for (const auto& [name, channel] :
         {std::pair("annotations.R", 0), {"annotations.G", 1}, {"annotations.B", 2}, {"annotations.A", 3}})
        all.push_back({name, &over.pixels[0][channel], 4});
    writeImage(path, picture, manifest, all);
}

} // namespace

void checkFigurePath(const std::filesystem::path& path) {
    figureFormat(path);
}

nlohmann::json annotationsJson(const Figure& figure) {
    if (!figure.any())
        return {};
    const DrawingReport report = describeDrawing(figure);
    nlohmann::json fonts = nlohmann::json::array();
    for (const DrawingReport::Font& font : report.fonts)
        fonts.push_back({{"family", font.family}, {"file", font.file}});
    nlohmann::json json = {
        {"cairo", report.cairo}, {"pango", report.pango}, {"dpi", figure.dpi}, {"fonts", fonts}};
    if (!report.leftOut.empty())
        json["leftOut"] = report.leftOut;
    return json;
}

void writeFigure(const std::filesystem::path& path, const Image& picture, const Figure& figure,
                 const std::string& manifest, std::span<const LayerChannel> layers, MemoryBudget& ram) {
    const PictureFormat format = figureFormat(path);
    if (isPage(format))
        return writePage(path, picture, figure, manifest, ram);
    if (!figure.any())
        return writeImage(path, picture, manifest, layers, dpiOf(figure));
    if (format == PictureFormat::exr)
        return writeExr(path, picture, figure, manifest, layers, ram);
    const Charge charge = ram.charge(sizeof(glm::vec4) * picture.pixels.size(), "the figure");
    Image annotated = picture;
    drawAnnotations(figure, annotated);
    writeImage(path, annotated, manifest, layers, dpiOf(figure));
}

#else

namespace {

void refuseAnnotations(const Figure& figure) {
    if (figure.any())
        throw InputError("annotations: this program was built without them");
}

} // namespace

void checkFigurePath(const std::filesystem::path& path) {
    checkImagePath(path);
}

nlohmann::json annotationsJson(const Figure& figure) {
    refuseAnnotations(figure);
    return {};
}

void writeFigure(const std::filesystem::path& path, const Image& picture, const Figure& figure,
                 const std::string& manifest, std::span<const LayerChannel> layers, MemoryBudget&) {
    refuseAnnotations(figure);
    writeImage(path, picture, manifest, layers);
}

#endif

} // namespace tessera
