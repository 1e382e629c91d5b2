// viewer/python/picture.cpp: see picture.h.
#include "viewer/python/picture.h"

#include "core/base/budget.h"
#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/base/threads.h"
#include "core/image/colour.h"
#include "core/image/image.h"
#include "core/scene/scene.h"
#include "render/pixels/picture_layers.h"
#include "render/renderer.h"
#include "viewer/annotations/figure.h"
#include "viewer/annotations/figure_file.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/manifest/manifest.h"
#include "viewer/cli/options/command.h"
#include "viewer/cli/options/command_table.h"
#include "viewer/cli/render/layers.h"
#include "viewer/cli/render/run_render.h"
#include "viewer/cli/render/scene_from_arguments.h"
#include "viewer/python/call.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <string>
#include <utility>
#include <vector>

namespace tessera::python {
namespace {

/// A picture in memory, with what its file would hold besides.
struct Picture {
    Image image; // linear, premultiplied, without its background
    std::optional<PictureLayers> layers;
    std::optional<Image> errors;
    LayerChoice choice;
    Figure figure; // what its file has over it
    std::string manifest;
    std::optional<glm::vec3> background; // linear
    std::vector<std::string> notes;
};

/// Numbers of an image's pixels, without a copy; to be read only.
/// @param owner  keeps them
py::array numbersOf(const Image& image, int first, int count, const py::handle& owner) {
    constexpr auto kNumber = static_cast<py::ssize_t>(sizeof(float)), kPixel = 4 * kNumber;
    std::vector<py::ssize_t> shape = {image.size.y, image.size.x}, strides = {kPixel * image.size.x, kPixel};
    if (count > 1) {
        shape.push_back(count);
        strides.push_back(kNumber);
    }
    py::array numbers(py::dtype::of<float>(), shape, strides, &image.pixels.front()[first], owner);
    numbers.attr("setflags")(py::arg("write") = false); // the manifest says what they are
    return numbers;
}

py::dict layersOfPicture(const py::object& self) {
    const auto& picture = self.cast<const Picture&>();
    py::dict out;
    if (picture.choice.albedo)
        out["albedo"] = numbersOf(picture.layers->albedo, 0, 3, self);
    if (picture.choice.normal)
        out["normal"] = numbersOf(picture.layers->normal, 0, 3, self);
    if (picture.choice.depth)
        out["depth"] = numbersOf(picture.layers->normal, 3, 1, self);
    if (picture.choice.error)
        out["error"] = numbersOf(*picture.errors, 0, 4, self);
    return out;
}

/// The picture on its background.
Image onBackground(const Picture& picture) {
    return picture.background ? overBackground(picture.image, *picture.background) : picture.image;
}

/// Linear premultiplied to sRGB of 8 bits, unassociated, as files have it.
void encode(const Image& image, int channels, std::uint8_t* first) {
    const auto quantised = [](double x) {
        return static_cast<std::uint8_t>(x > 0 ? std::lround(std::min(x, 1.0) * 255) : 0);
    };
    parallelFor(static_cast<std::size_t>(image.size.y), 0, [&](std::size_t y) {
        std::uint8_t* to = first + y * static_cast<std::size_t>(image.size.x * channels);
        for (int x = 0; x < image.size.x; ++x) {
            const glm::vec4& p = image.at(x, static_cast<int>(y));
            const double a = std::min(static_cast<double>(p.a), 1.0);
            for (int c = 0; c < 3; ++c) {
                const double straight = a > 0 ? static_cast<double>(p[c]) / a : 0.0;
                *to++ = quantised(srgbFromLinear(std::isnan(straight) ? 0.0 : straight));
            }
            if (channels == 4)
                *to++ = quantised(a);
        }
    });
}

/// As picture files of 8 bits have it: on the background, with its annotations, sRGB; alpha only where a
/// pixel is not opaque.
py::array_t<std::uint8_t> srgbOf(const Picture& picture) {
    Image image;
    bool opaque = false;
    Call call((py::none()));
    call.run([&] {
        image = onBackground(picture);
        annotate(image, picture.figure);
        opaque = std::all_of(image.pixels.begin(), image.pixels.end(),
                             [](const glm::vec4& p) { return p.a >= 1; });
    });
    const int channels = opaque ? 3 : 4;
    py::array_t<std::uint8_t> out({image.size.y, image.size.x, channels});
    std::uint8_t* const first = out.mutable_data();
    call.run([&] { encode(image, channels, first); });
    return out;
}

void save(const Picture& picture, const std::string& path, const std::string& ram) {
    checkFigurePath(path);
    checkOutputFile(path);
    std::vector<LayerChannel> channels;
    if (std::filesystem::path(path).extension() == ".exr") { // the others have no place for layers
        const auto add = [&](const char* layer, const Image& image, const char* names, int from) {
            for (int c = 0; names[c] != '\0'; ++c)
                channels.push_back({std::string(layer) + "." + names[c], &image.pixels[0][from + c], 4});
        };
        if (picture.choice.albedo)
            add("albedo", picture.layers->albedo, "RGB", 0);
        if (picture.choice.normal)
            add("normal", picture.layers->normal, "XYZ", 0);
        if (picture.choice.depth)
            add("depth", picture.layers->normal, "Z", 3);
        if (picture.choice.error)
            add("error", *picture.errors, "RGBA", 0);
    }
    Call call((py::none()));
    MemoryBudget budget("RAM", "ram", budgetBytes(ram, "ram", call.common()));
    call.run([&] {
        writeFigure(path, onBackground(picture), picture.figure, picture.manifest, channels, budget);
    });
}

std::vector<std::string> optionsOfRender() {
    CommandLine line("tessera", TESSERA_VERSION, "");
    Command command = line.program().command("render", "");
    addRenderOptions(command, std::make_shared<RenderArguments>());
    return longNames(command.table());
}

/// The arguments of `tessera render`.
/// @param words  of a command line, behind the picture's name: "--size=640x480"
std::shared_ptr<RenderArguments> argumentsOf(const std::string& in, const std::string& out,
                                             const std::vector<std::string>& given) {
    auto arguments = std::make_shared<RenderArguments>();
    CommandLine line("tessera", TESSERA_VERSION, "");
    Command command = line.program().command("render", "");
    addRenderOptions(command, arguments);
    std::vector<std::string> words = {"tessera", "render", in, "--output=" + out};
    words.insert(words.end(), given.begin(), given.end());
    std::vector<char*> pointers;
    for (std::string& word : words)
        pointers.push_back(word.data());
    line.parse(static_cast<int>(pointers.size()), pointers.data());
    return arguments;
}

/// @param in  a path, or how messages name the scene
/// @param scene  in place of the path's; null: that one
std::unique_ptr<Picture> render(const std::string& in, const Scene* scene,
                                const std::vector<std::string>& words, py::object progress) {
    Call call(std::move(progress));
    // The picture's name only says that its file could hold layers.
    const auto arguments = argumentsOf(in, "picture.exr", words);
    auto picture = std::make_unique<Picture>();
    const std::optional<Scene> own =
        scene ? std::optional(*scene) : std::nullopt; // while it is drawn nobody changes it
    call.run([&] {
        runRender(*arguments, call.common(), own ? &*own : nullptr,
                  [&](const RenderTask& task, RenderResult& result, const Figure& figure,
                      const nlohmann::json& manifest) {
                      picture->figure = figure;
                      picture->image = std::move(result.image);
                      picture->layers = std::move(result.layers);
                      picture->errors = std::move(result.pixelErrors);
                      picture->choice = task.layers;
                      picture->background = task.scene.background;
                      picture->manifest = manifestText(manifest);
                  });
    });
    picture->notes = call.notes();
    return picture;
}

/// Writes what `tessera render` writes: a picture, a figure, a film, the wall of a line.
std::vector<std::string> renderFile(const std::string& in, const Scene* scene, const std::string& out,
                                    const std::vector<std::string>& words, py::object progress) {
    Call call(std::move(progress));
    const auto arguments = argumentsOf(in, out, words);
    if (scene)
        arguments->scene = *scene;
    call.run([&] { runRender(*arguments, call.common()); });
    return call.notes();
}

} // namespace

void addPictures(py::module_& module) {
    py::class_<Picture>(module, "Picture")
        .def_property_readonly(
            "pixels",
            [](const py::object& self) { return numbersOf(self.cast<const Picture&>().image, 0, 4, self); })
        .def_property_readonly("layers", &layersOfPicture)
        .def_property_readonly("notes", [](const Picture& picture) { return picture.notes; })
        .def_property_readonly("manifest", [](const Picture& picture) { return picture.manifest; })
        .def_property_readonly("background",
                               [](const Picture& picture) -> py::object {
                                   if (!picture.background)
                                       return py::none();
                                   const glm::vec3& c = *picture.background;
                                   return py::make_tuple(c.r, c.g, c.b);
                               })
        .def("srgb", &srgbOf)
        .def("save", &save, py::arg("path"), py::arg("ram"));
    module.def("options_of_render", &optionsOfRender);
    module.def("render", &render, py::arg("path"), py::arg("scene").none(true), py::arg("words"),
               py::arg("progress"));
    module.def("render_file", &renderFile, py::arg("path"), py::arg("scene").none(true), py::arg("out"),
               py::arg("words"), py::arg("progress"));
}

} // namespace tessera::python
