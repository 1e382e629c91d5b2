// viewer/window/panels.cpp: see panels.h.
#include "viewer/window/panels.h"

#include "core/budget.h" // formatBytes
#include "core/look.h"
#include "viewer/session/camera_moves.h"

#include <algorithm>
#include <cstdio>
#include <imgui.h>

namespace tessera {
namespace {

const char* const kStages[] = {"moving", "loading", "whole", "still"};

/// The look that a scene has, "its own" where it is none of those with a name.
std::string lookOf(const Scene& scene) {
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

void Panels::files(Desk& desk) {
    ImGui::SetNextItemWidth(-60);
    const bool entered = ImGui::InputTextWithHint("##path", "file or folder", path_, sizeof path_,
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    ImGui::SameLine();
    if ((ImGui::Button("open") || entered) && path_[0] != '\0')
        desk.open(path_);
    if (!desk.settings().recent.empty() && ImGui::BeginCombo("##recent", "recent ...")) {
        for (const auto& path : desk.settings().recent)
            if (ImGui::Selectable(path.string().c_str())) {
                desk.open(std::filesystem::path(path));
                break;
            }
        ImGui::EndCombo();
    }
    if (!desk.volume())
        return;
    if (ImGui::Button("save picture"))
        desk.savePicture();
    ImGui::SameLine();
    if (ImGui::Button("save scene"))
        desk.saveScene();
}

void Panels::view(Desk& desk) {
    const char* const names[] = {"anterior", "posterior", "left", "right", "superior", "inferior"};
    for (int n = 0; n < 6; ++n) {
        if (n % 3 != 0)
            ImGui::SameLine();
        if (ImGui::Button(names[n], {98, 0}))
            desk.setCamera(seenFrom(desk.camera(), static_cast<View>(n)), false);
    }
    int projection = desk.camera().projection == Projection::parallel;
    ImGui::RadioButton("perspective", &projection, 0);
    ImGui::SameLine();
    ImGui::RadioButton("parallel", &projection, 1);
    if (projection != static_cast<int>(desk.camera().projection == Projection::parallel))
        desk.setCamera(
            projectedBy(desk.camera(), projection ? Projection::parallel : Projection::perspective), false);
    if (desk.camera().projection == Projection::perspective) {
        float angle = static_cast<float>(desk.camera().viewAngle);
        if (ImGui::SliderFloat("angle", &angle, 5, 150, "%.0f deg")) {
            Camera camera = desk.camera();
            camera.viewAngle = static_cast<double>(angle);
            desk.setCamera(camera, true);
        }
    }
    ImGui::Checkbox("fly (W A S D, Q E, drag to look)", &desk.flying);
    if (ImGui::Button("whole volume (R)"))
        desk.resetCamera();
}

void Panels::mode(Desk& desk) {
    Scene scene = desk.scene();
    const std::vector<std::string>& names = modeNames();
    const auto now = static_cast<std::size_t>(scene.mode);
    bool changed = false;
    if (ImGui::BeginCombo("##mode", names[now].c_str())) {
        for (std::size_t n = 0; n < names.size(); ++n) {
            const Mode mode = static_cast<Mode>(n);
            if (mode == Mode::slice) // planes are beside the volume
                continue;
            if (ImGui::Selectable(names[n].c_str(), n == now)) {
                if (mode == Mode::isosurface && scene.surfaces.empty()) {
                    desk.tell("add an isosurface first");
                    continue;
                }
                desk.beginEdit();
                scene.mode = mode;
                changed = true;
            }
        }
        ImGui::EndCombo();
    }
    if (scene.mode != Mode::composite && scene.mode != Mode::isosurface) {
        const GreyWindow window = windowOf(scene.window, desk.volume()->values);
        float numbers[2] = {static_cast<float>(window.centre), static_cast<float>(window.width)};
        const bool dragged = ImGui::DragFloat2("window", numbers, 2, 0, 0, "%.0f");
        if (edited())
            desk.beginEdit();
        if (dragged && numbers[1] > 0) {
            scene.window = GreyWindow{static_cast<double>(numbers[0]), static_cast<double>(numbers[1])};
            desk.setScene(scene, true);
        }
        if (ImGui::BeginCombo("##names", "named windows ...")) {
            for (const std::string& name : windowNames())
                if (ImGui::Selectable(name.c_str())) {
                    desk.beginEdit();
                    scene.window = windowOf(name, desk.volume()->values);
                    changed = true;
                }
            ImGui::EndCombo();
        }
    }
    if (changed)
        desk.setScene(scene, false);
}

void Panels::planes(Desk& desk) {
    ImGui::Checkbox("beside the volume (X)", &desk.showSlices);
    SliceWish wish = desk.slices();
    bool changed = false;
    if (ImGui::BeginCombo("window", "choose ...")) {
        for (const std::string& name : windowNames())
            if (ImGui::Selectable(name.c_str())) {
                wish.window = windowOf(name, desk.volume()->values);
                changed = true;
            }
        ImGui::EndCombo();
    }
    float window[2] = {static_cast<float>(wish.window.centre), static_cast<float>(wish.window.width)};
    if (ImGui::DragFloat2("centre, width", window, 2, 0, 0, "%.0f") && window[1] > 0) {
        wish.window = {static_cast<double>(window[0]), static_cast<double>(window[1])};
        changed = true;
    }
    if (changed)
        desk.setSlices(wish);
}

void Panels::light(Desk& desk) {
    if (lookOf_ != desk.asked()) {
        lookOf_ = desk.asked();
        look_ = lookOf(desk.scene());
    }
    if (ImGui::BeginCombo("look", look_.c_str())) {
        for (const std::string& name : lookNames())
            if (ImGui::Selectable(name.c_str(), name == look_)) {
                Scene scene = desk.scene();
                applyLook(name, scene);
                desk.beginEdit();
                desk.setScene(scene, false);
            }
        ImGui::EndCombo();
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

void Panels::surfaces(Desk& desk) {
    Scene scene = desk.scene();
    const VolumeSeen& volume = *desk.volume();
    bool changed = false;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        Isosurface& surface = scene.surfaces[i];
        float value = static_cast<float>(surface.value), opacity = static_cast<float>(surface.opacity);
        ImGui::SetNextItemWidth(120);
        const bool moved = ImGui::DragFloat(
            "##value", &value, static_cast<float>((volume.values.highest - volume.values.lowest) / 2000),
            static_cast<float>(volume.values.lowest), static_cast<float>(volume.values.highest), "%.0f");
        if (edited())
            desk.beginEdit();
        ImGui::SameLine();
        ImGui::SetNextItemWidth(90);
        const bool faded = ImGui::SliderFloat("##opacity", &opacity, 0, 1, "%.2f");
        if (edited())
            desk.beginEdit();
        ImGui::SameLine();
        const bool gone = ImGui::SmallButton("remove");
        ImGui::PopID();
        if (moved || faded) {
            surface.value = static_cast<double>(value);
            surface.opacity = static_cast<double>(opacity);
            changed = true;
        }
        if (gone) {
            desk.beginEdit();
            scene.surfaces.erase(scene.surfaces.begin() + static_cast<std::ptrdiff_t>(i));
            changed = true;
            break;
        }
    }
    if (scene.surfaces.size() < Scene::kMaxSurfaces && ImGui::Button("add isosurface")) {
        desk.beginEdit();
        const auto& points = desk.function().opacityPoints();
        scene.surfaces.push_back({points.empty() ? volume.values.lowest : points.back().value, {1, 1, 1}, 1});
        changed = true;
    }
    if (changed)
        desk.setScene(scene, false);
}

void Panels::state(Desk& desk) {
    const ViewingState& s = desk.state();
    const auto now = WindowClock::now();
    ImGui::Text("%.0f pictures a second, %.0f ms after input", desk.latency().picturesPerSecond(now),
                desk.latency().lastMs);
    ImGui::Text("half within %.0f ms, 19 of 20 within %.0f ms", desk.latency().percentileMs(0.5),
                desk.latency().percentileMs(0.95));
    if (const ShownPicture* picture = desk.picture())
        ImGui::Text("%s: %d x %d, %.0f ms", kStages[static_cast<int>(picture->stage)], picture->image.size.x,
                    picture->image.size.y, picture->drawingMs);
    ImGui::Text("RAM %s of %s", formatBytes(s.ramUsed).c_str(), formatBytes(s.ramLimit).c_str());
    ImGui::Text("bricks' memory %s of %s", formatBytes(s.gpuUsed).c_str(), formatBytes(s.gpuLimit).c_str());
    if (s.bricksShown > 0)
        ImGui::Text("%.0f %% of %zu bricks at their level, levels %d to %d",
                    100.0 * static_cast<double>(s.bricksAsWanted) / static_cast<double>(s.bricksShown),
                    s.bricksShown, s.finestLevel, std::max(s.finestLevel, s.coarsestLevel));
    if (const auto all = s.chunksThere + s.chunksMissed; all > 0)
        ImGui::Text("%.0f %% of %llu chunks were read before they were asked for",
                    100.0 * static_cast<double>(s.chunksThere) / static_cast<double>(all),
                    static_cast<unsigned long long>(all));
    ImGui::Checkbox("colour bricks by level (L)", &desk.showLevels);
    if (s.movesLeft > 0)
        ImGui::Text("%zu bricks are on their way", s.movesLeft);
    if (s.lightIsCoarse)
        ImGui::TextUnformatted("light is coarse yet");
    if (s.drawingStill)
        ImGui::TextUnformatted("drawing the still ...");
    if (s.noStills)
        ImGui::TextWrapped("no stills: --ram is too small for one of this volume beside these pictures");
    if (!s.measured.empty())
        ImGui::TextWrapped("%s", s.measured.c_str());
    ImGui::TextWrapped("%s", s.engine.c_str());
}

void Panels::draw(Desk& desk, Tools& tools, CutHandles& cuts, Endoscopy& endoscopy, float height) {
    if (!desk.showPanels)
        return;
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({kWidth, height});
    ImGui::Begin("panels", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus);
    files(desk);
    if (desk.volume()) {
        const auto part = [&](const char* name, const auto& body, bool open = true) {
            if (ImGui::CollapsingHeader(name, open ? ImGuiTreeNodeFlags_DefaultOpen : 0))
                body();
        };
        part("View", [&] { view(desk); });
        part("Transfer function", [&] { function_.draw(desk); });
        part("Mode", [&] { mode(desk); });
        part("Planes", [&] { planes(desk); });
        part("Measure and cut", [&] {
            tools.panel(desk);
            cuts.panel(desk);
        });
        part(
            "Endoscopy", [&] { endoscopy.panel(desk); }, false);
        part("Light", [&] { light(desk); });
        part(
            "Isosurfaces", [&] { surfaces(desk); }, false);
        part("State", [&] { state(desk); });
    }
    ImGui::End();
}

void drawHelp(Desk& desk) {
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
                                       {"double click", "what is there comes to the middle"},
                                       {"1 ... 6", "anterior, posterior, left, right, superior, inferior"},
                                       {"P, X", "perspective or parallel; planes"},
                                       {"planes: left drag", "the crosshair"},
                                       {"planes: right drag", "window: centre, width"},
                                       {"planes: wheel, Ctrl wheel", "through the volume; nearer"},
                                       {"R", "whole volume"},
                                       {"F; W A S D, Q E", "fly"},
                                       {"Ctrl Z, Ctrl Y", "undo, redo"},
                                       {"Space, arrows, Home", "along a line: fly, step, look ahead again"},
                                       {"Shift arrows, up, down", "along a line: steer off it"},
                                       {"L", "bricks coloured by their level"},
                                       {"M, G, C", "measure a distance, an angle, a circle"},
                                       {"K, Shift K", "scissors: cut the inside away, the outside"},
                                       {"B, N", "crop box; a plane that cuts, through the crosshair"},
                                       {"Tab; Ctrl Q", "panels; close"},
                                       {"F12, Ctrl S", "save the picture, the scene"},
                                       {"?", "this list"}};
        if (ImGui::BeginTable("keys", 2)) {
            for (const auto& row : rows) {
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(row[0]);
                ImGui::TableNextColumn();
                ImGui::TextWrapped("%s", row[1]);
            }
            ImGui::EndTable();
        }
    }
    ImGui::End();
}

} // namespace tessera
