// viewer/window/panels.cpp: see panels.h.
#include "viewer/window/panels.h"

#include "core/base/budget.h" // formatBytes
#include "core/scene/scene_presets.h"
#include "viewer/window/beside.h"
#include "viewer/window/boxes.h"
#include "viewer/window/overlays.h"

#include <algorithm>
#include <cstdio>
#include <imgui.h>

namespace tessera {
namespace {

const char* const kStages[] = {"moving", "loading", "whole", "round", "still"};

/// The lighting preset of a scene, "its own" for other lighting.
std::string lookOf(Scene scene) {
    for (SceneVolume& volume : scene.volumes)
        volume.labels = {}; // no part of it, and they may be thousands
    const std::string text = sceneJson(scene);
    for (const std::string& name : lookNames()) {
        Scene same = scene;
        applyLook(name, same);
        if (sceneJson(same) == text)
            return name;
    }
    return "its own";
}

bool edited() {
    return ImGui::IsItemActivated();
}

} // namespace

void Panels::files(WindowState& desk) {
    ImGui::SetNextItemWidth(-60);
    const bool entered = ImGui::InputTextWithHint("##path", "file or folder", path_, sizeof path_,
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    ImGui::SameLine();
    if (ImGui::Button("open") || entered) {
        if (path_[0] != '\0')
            desk.open(path_);
        else
            desk.showBrowser = !desk.showBrowser;
    }
}

/// A slider over the phases of the volume. That under it is opened when it is let go.
void Panels::phases(WindowState& desk) {
    const std::vector<std::string>& labels = desk.volume()->phases;
    if (labels.size() < 2)
        return;
    const auto count = static_cast<int>(labels.size());
    int shown = std::clamp(phase_ > 0 ? phase_ : desk.volume()->phase, 1, count);
    std::string words = std::to_string(shown) + " of " + std::to_string(count) + ": ";
    for (const char letter : labels[static_cast<std::size_t>(shown) - 1])
        words += letter == '%' ? "%%" : std::string(1, letter);
    ImGui::SetNextItemWidth(-60);
    ImGui::SliderInt("phase", &shown, 1, count, words.c_str(), ImGuiSliderFlags_NoInput);
    if (ImGui::IsItemDeactivatedAfterEdit())
        desk.showPhase(shown);
    phase_ = ImGui::IsItemActive() ? shown : 0;
}

void Panels::saving(WindowState& desk) {
    ImGui::SetNextItemWidth(-1);
    const std::string stem = desk.volume()->path.stem().string();
    ImGui::InputTextWithHint("##name", ("name or path, else " + stem).c_str(), name_, sizeof name_);
    const glm::ivec2 size = desk.scene().imageSize;
    const auto sizeName = [&](int times) {
        return std::to_string(times * size.x) + " x " + std::to_string(times * size.y) +
               (times == 1 ? ", as shown" : "");
    };
    const std::vector<std::string> sizes = {sizeName(1), sizeName(2), sizeName(4)};
    if (const auto taken = nameBox("pixels", sizeName(times_), sizes))
        times_ = *taken == sizes[0] ? 1 : *taken == sizes[1] ? 2 : 4;
    const std::vector<std::string> names = {"black", "white", "#808080", "transparent"};
    std::string chosen = "its own";
    for (const std::string& name : names)
        if (parseBackground(name, "background") == desk.scene().background)
            chosen = name;
    if (const auto taken = nameBox("background", chosen, names)) {
        Scene scene = desk.scene();
        scene.background = parseBackground(*taken, "background");
        desk.beginEdit();
        desk.setScene(scene, false);
    }
    ImGui::Checkbox("scale bar in the picture", &desk.savesScaleBar);
    bool legend = desk.showsLegend();
    if (ImGui::Checkbox("colour legend", &legend))
        desk.showLegend = legend;
    ImGui::SameLine();
    ImGui::Checkbox("in the picture", &desk.savesLegend);
    if (ImGui::Button("save picture (F12)"))
        desk.savePicture(name_, times_);
    ImGui::SameLine();
    if (ImGui::Button("save scene"))
        desk.saveScene(name_);
}

void Panels::view(WindowState& desk) {
    const char* const names[] = {"anterior", "posterior", "left", "right", "superior", "inferior"};
    for (int n = 0; n < 6; ++n) {
        if (n % 3 != 0)
            ImGui::SameLine();
        if (ImGui::Button(names[n], {98, 0}))
            desk.fitView(static_cast<View>(n));
    }
    int projection = desk.camera().projection == Projection::parallel;
    ImGui::RadioButton("perspective", &projection, 0);
    ImGui::SameLine();
    ImGui::RadioButton("parallel", &projection, 1);
    if (projection != static_cast<int>(desk.camera().projection == Projection::parallel))
        desk.setProjection(projection ? Projection::parallel : Projection::perspective);
    if (desk.camera().projection == Projection::perspective) {
        float angle = static_cast<float>(desk.camera().viewAngle);
        if (ImGui::SliderFloat("angle", &angle, 5, 150, "%.0f deg")) {
            Camera camera = desk.camera();
            camera.viewAngle = static_cast<double>(angle);
            desk.setCamera(camera, true);
        }
    }
    ImGui::Checkbox("fly (W A S D, Q E, drag to look)", &desk.flying);
    if (ImGui::Button("show all (R)"))
        desk.fitView();
    ImGui::SameLine();
    if (ImGui::Button("as opened"))
        desk.resetCamera();
}

void Panels::planes(WindowState& desk) {
    ImGui::Checkbox("beside the volume (X)", &desk.showSlices);
    if (desk.showSlices) {
        const std::vector<std::string> names = {"all three", "axial", "coronal", "sagittal"};
        if (const auto taken =
                nameBox("shown", names[static_cast<std::size_t>(desk.enlargedPlane + 1)], names))
            desk.enlargedPlane =
                static_cast<int>(std::find(names.begin(), names.end(), *taken) - names.begin()) - 1;
    }
    SliceWish wish = desk.slices();
    bool ignored = false; // planes are in no scene
    if (const auto window = windowBox(wish.window, desk.volume()->values, Mode::slice, ignored)) {
        wish.window = *window;
        desk.setSlices(wish);
    }
}

/// Cuts and all other edits, one after the other.
void Panels::undoPanel(WindowState& desk) {
    if (desk.scene().cuts.any() && ImGui::Button("remove all cuts")) {
        desk.beginEdit();
        Scene scene = desk.scene();
        scene.cuts = {};
        desk.setScene(scene, false);
    }
    if (ImGui::Button("undo (Ctrl Z)"))
        desk.undo();
    ImGui::SameLine();
    if (ImGui::Button("redo (Ctrl Y)"))
        desk.redo();
}

void Panels::light(WindowState& desk) {
    if (lookOf_ != desk.asked()) {
        lookOf_ = desk.asked();
        look_ = lookOf(desk.scene());
    }
    if (const auto name = nameBox("lighting", look_, lookNames())) {
        Scene lit = desk.scene();
        applyLook(*name, lit);
        desk.beginEdit();
        desk.setScene(lit, false);
    }
    if (bool paths = desk.scene().lighting.transport.has_value();
        ImGui::Checkbox("paths of light, at rest", &paths)) {
        Scene other = desk.scene();
        Lighting& light = other.lighting;
        if (paths && !paths_.transport) {
            Scene look = other;
            applyLook("cinematic", look);
            paths_ = look.lighting;
        } else if (!paths) {
            paths_ = light;
        }
        light.transport = paths ? paths_.transport : std::nullopt;
        if (paths || !reflects(other)) // mirrors show it too
            light.environment = paths ? paths_.environment : std::nullopt;
        desk.beginEdit();
        desk.setScene(other, false);
    }
    Scene scene = desk.scene();
    bool changed = false;
    if (ImGui::Checkbox("shading", &scene.shading.on)) {
        desk.beginEdit();
        changed = true;
    }
    if (scene.shading.on) {
        const auto slider = [&](const char* name, double& value, float most) {
            float shown = static_cast<float>(value);
            const bool moved = ImGui::SliderFloat(name, &shown, 0, most, "%.2f");
            if (edited())
                desk.beginEdit();
            if (moved)
                value = static_cast<double>(shown), changed = true;
        };
        slider("ambient", scene.shading.ambient, 1);
        slider("diffuse", scene.shading.diffuse, 1);
        slider("specular", scene.shading.specular, 1);
    }
    if (changed)
        desk.setScene(scene, false);
}

void Panels::state(WindowState& desk) {
    const ViewingState& s = desk.state();
    const auto now = WindowClock::now();
    wrapped("%.0f pictures a second, %.0f ms after input", desk.latency().picturesPerSecond(now),
            desk.latency().lastMs);
    wrapped("half within %.0f ms, 19 of 20 within %.0f ms", desk.latency().percentileMs(0.5),
            desk.latency().percentileMs(0.95));
    if (const ShownPicture* picture = desk.picture()) {
        wrapped("%s: %d x %d, %.0f ms", kStages[static_cast<int>(picture->stage)], picture->image.size.x,
                picture->image.size.y, picture->drawingMs);
        if (picture->samples)
            wrapped("%s", samplesText(*picture).c_str());
    }
    wrapped("RAM %s of %s", formatBytes(s.ramUsed).c_str(), formatBytes(s.ramLimit).c_str());
    wrapped("bricks' memory %s of %s", formatBytes(s.gpuUsed).c_str(), formatBytes(s.gpuLimit).c_str());
    if (s.bricksShown > 0)
        wrapped("%.0f %% of %zu bricks at their level, levels %d to %d",
                100.0 * static_cast<double>(s.bricksAsWanted) / static_cast<double>(s.bricksShown),
                s.bricksShown, s.finestLevel, std::max(s.finestLevel, s.coarsestLevel));
    if (const auto all = s.chunksThere + s.chunksMissed; all > 0)
        wrapped("%.0f %% of %llu requested chunks were in the cache",
                100.0 * static_cast<double>(s.chunksThere) / static_cast<double>(all),
                static_cast<unsigned long long>(all));
    ImGui::Checkbox("colour bricks by level (L)", &desk.showLevels);
    if (s.movesLeft > 0)
        wrapped(s.movesLeft == 1 ? "%zu brick is on its way" : "%zu bricks are on their way", s.movesLeft);
    if (s.lightIsCoarse)
        wrapped("light is still coarse");
    if (s.drawingStill)
        wrapped("drawing the still ...");
    if (s.noStills)
        wrapped("no stills: --ram is too small for one of this volume beside these pictures");
    if (!s.firstAlone.empty())
        wrapped("pictures in motion show the first volume alone: %s", s.firstAlone.c_str());
    if (!s.measured.empty())
        wrapped("%s", s.measured.c_str());
    wrapped("%s", s.engine.c_str());
    for (const std::string& remark : desk.volume()->info.remarks)
        wrapped("%s", remark.c_str());
}

void Panels::draw(WindowState& desk, Tools& tools, CutHandles& cuts, Endoscopy& endoscopy, float height) {
    if (!desk.showPanels)
        return;
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({kWidth, height});
    ImGui::Begin("panels", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus);
    files(desk);
    if (desk.volume()) {
        phases(desk);
        const auto part = [&](const char* name, const auto& body, bool open = true) {
            if (!ImGui::CollapsingHeader(name, open ? ImGuiTreeNodeFlags_DefaultOpen : 0))
                return;
            ImGui::PushID(name); // parts have widgets of the same names
            body();
            ImGui::PopID();
        };
        part(
            "Save", [&] { saving(desk); }, false);
        part("View", [&] { view(desk); });
        if (desk.beside())
            part("Two scans", [&] { besidePanel(desk, *desk.beside()); });
        part("Transfer function", [&] { function_.draw(desk); });
        if (desk.volume()->labels)
            part("Labels", [&] { labels_.draw(desk); });
        else
            labels_.forget();
        if (!desk.scene().meshes.empty())
            part("Meshes", [&] { meshes_.draw(desk); });
        part("Mode", [&] { modePanel(desk); });
        part("Planes", [&] { planes(desk); });
        part("Measure", [&] { tools.panel(desk); });
        part("Cut", [&] {
            tools.scissorsPanel(desk);
            cuts.panel(desk);
            undoPanel(desk);
        });
        part(
            "Endoscopy", [&] { endoscopy.panel(desk); }, false);
        part("Light", [&] { light(desk); });
        part(
            "Isosurfaces", [&] { surfacesPanel(desk); }, false);
        part("State", [&] { state(desk); });
    }
    ImGui::End();
}

void drawHelp(WindowState& desk) {
    if (!desk.showHelp)
        return;
    ImGui::SetNextWindowSize({430, 0});
    if (ImGui::Begin("Keys and mouse", &desk.showHelp,
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoResize)) {
        const char* const rows[][2] = {{"left drag", "turn"},
                                       {"Shift + left, middle drag", "shift"},
                                       {"right drag, wheel", "nearer, farther"},
                                       {"Ctrl + left drag", "roll"},
                                       {"Alt + left drag", "shift and stretch the transfer function"},
                                       {"double click", "centre the view there"},
                                       {"1 ... 6", "anterior, posterior, left, right, superior, inferior"},
                                       {"P, X", "perspective or parallel; planes"},
                                       {"planes: left drag", "the crosshair"},
                                       {"planes: right drag", "window: centre, width"},
                                       {"planes: wheel, Ctrl wheel", "through the volume; zoom"},
                                       {"planes: double click, border", "one alone, larger; drag: resize"},
                                       {"R", "fit, in the same direction"},
                                       {"F; W A S D, Q E", "fly"},
                                       {"Ctrl Z, Ctrl Y", "undo, redo"},
                                       {"Space, arrows, Home", "along a line: fly, step, look ahead again"},
                                       {"Shift arrows, up, down", "along a line: steer off it"},
                                       {"L", "bricks coloured by their level"},
                                       {", and .", "the phase before, the next one"},
                                       {"M, G, C", "measure a distance, an angle, a circle"},
                                       {"K, Shift K", "scissors: remove the inside, the outside"},
                                       {"B, N", "crop box; a plane that cuts, through the crosshair"},
                                       {"Tab; Ctrl Q", "panels; close"},
                                       {"F12, Ctrl S", "save the picture, the scene"},
                                       {"Ctrl O", "open: folders and recent files"},
                                       {"?", "this list"}};
        if (ImGui::BeginTable("keys", 2)) {
            for (const auto& row : rows) {
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(row[0]);
                ImGui::TableNextColumn();
                ImGui::TextWrapped("%s", row[1]);
            }
            if (desk.volume() && desk.volume()->labels) {
                ImGui::TableNextColumn();
                ImGui::TextUnformatted("Ctrl Shift + click");
                ImGui::TableNextColumn();
                ImGui::TextWrapped("the label there alone; again: all labels");
            }
            ImGui::EndTable();
        }
    }
    ImGui::End();
}

} // namespace tessera
