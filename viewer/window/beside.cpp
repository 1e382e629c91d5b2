// viewer/window/beside.cpp: see beside.h.
#include "viewer/window/beside.h"

#include "core/scene/mode.h"
#include "viewer/window/boxes.h" // wrapped

#include <glm/common.hpp>
#include <imgui.h>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

glm::dvec3 middleOf(const VolumeInfo& info) {
    return {info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1)};
}

bool inOneFrame(const VolumeInfo& a, const VolumeInfo& b) {
    return !a.frameOfReference.empty() && a.frameOfReference == b.frameOfReference;
}

/// Around a volume, along the patient's axes, mm.
struct Box {
    glm::dvec3 low{1e30}, high{-1e30};
    bool has(const glm::dvec3& mm) const { return glm::clamp(mm, low, high) == mm; }
};
Box boxOf(const VolumeInfo& info) {
    Box box;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 voxel =
            glm::dvec3(info.extentVoxels) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
        const glm::dvec3 mm(info.patientFromVoxel * glm::dvec4(voxel, 1));
        box.low = glm::min(box.low, mm);
        box.high = glm::max(box.high, mm);
    }
    return box;
}

void move(Camera& camera, const glm::dvec3& by) {
    camera.position += by;
    camera.focalPoint += by;
}

/// Without boxes in voxels, which are of one volume.
Cuts moved(Cuts cuts, const glm::dvec3& by) {
    std::erase_if(cuts.boxes, [](const CropBox& box) { return box.space == CropBox::Space::voxels; });
    for (CropBox& box : cuts.boxes) {
        box.low += by;
        box.high += by;
    }
    for (CutPlane& plane : cuts.planes)
        plane.point += by;
    for (Scissors& scissors : cuts.scissors)
        move(scissors.camera, by);
    return cuts;
}

/// The axis along which a plane's position is.
int axisOf(const SlicePlane& slice) {
    return slice.orientation == Orientation::axial ? 2 : slice.orientation == Orientation::coronal ? 1 : 0;
}

/// @param middle  of its volume, where a plane without a position lies
SlicePlane moved(SlicePlane slice, const glm::dvec3& middle, const glm::dvec3& by) {
    const int axis = axisOf(slice);
    slice.point += by;
    slice.positionMm = slice.positionMm.value_or(middle[axis]) + by[axis];
    return slice;
}

} // namespace

BesideLinks::Places placesOf(const VolumeInfo& from, const VolumeInfo& to, const BesideLinks& links) {
    const bool meet = inOneFrame(from, to) || boxOf(from).has(middleOf(to)) || boxOf(to).has(middleOf(from));
    return links.places.value_or(meet ? BesideLinks::Places::coordinates : BesideLinks::Places::middles);
}

glm::dvec3 shiftBetween(const VolumeInfo& from, const VolumeInfo& to, const BesideLinks& links) {
    return placesOf(from, to, links) == BesideLinks::Places::coordinates ? glm::dvec3(0)
                                                                         : middleOf(to) - middleOf(from);
}

Scene sceneBeside(const Scene& scene, const VolumeInfo& of, const VolumeSeen& other,
                  const BesideLinks& links) {
    const glm::dvec3 by = shiftBetween(of, other.info, links);
    Scene beside = scene;
    beside.volumes = {other.scene.volumes.front()};
    const SceneVolume& look = scene.volumes.front();
    if (links.look && of.unit == other.info.unit) {
        beside.volumes.front().transferFunction = look.transferFunction;
        beside.volumes.front().window = look.window;
        beside.volumes.front().valueColour = look.valueColour;
    } else {
        beside.window = other.scene.window;
    }
    beside.meshes.clear();
    beside.measurements.clear();
    beside.annotations = {};
    beside.cuts = links.cuts ? moved(scene.cuts, by) : other.scene.cuts;
    beside.slice = moved(scene.slice, middleOf(of), by);
    if (auto* const camera = std::get_if<Camera>(&beside.camera))
        move(*camera, by);
    return beside;
}

Beside::Beside(std::unique_ptr<Viewing> viewing, std::filesystem::path path)
    : viewing_(std::move(viewing)), path_(std::move(path)) {}

void Beside::update(WindowState& desk, const glm::ivec2& pictureSize) {
    if (!opened_ && pictureSize.x > 0) {
        viewing_->open(path_, pictureSize);
        opened_ = true;
    }
    state_ = viewing_->state();
    if (!state_.problem.empty()) {
        desk.tell(name() + ": " + state_.problem, true);
        viewing_->problemSeen();
    }
    if (const std::string notice = viewing_->takeNotice(); !notice.empty())
        desk.tell(notice);
    if (auto volume = viewing_->volume(); volume != volume_) {
        volume_ = std::move(volume);
        of_ = nullptr; // it is asked for anew
        if (volume_)
            window_ = windowOf(std::string("auto"), volume_->values, Mode::slice);
    }
    picked_ = viewing_->picked();
    if (picked_ && picked_->number <= pickedBefore_)
        picked_.reset();
    if (!volume_ || !desk.volume() || desk.isFitting())
        return;
    const bool moving = !desk.hasAsked();
    if (of_ == desk.volume() && asked_ == desk.asked() && size_ == pictureSize && moving_ == moving)
        return;
    of_ = desk.volume();
    asked_ = desk.asked();
    size_ = pictureSize;
    moving_ = moving;
    scene_ = sceneNow(desk);
    scene_.imageSize = pictureSize;
    wished_ = viewing_->show(scene_, moving);
    if (picked_)
        pickedBefore_ = picked_->number;
    picked_.reset();
}

Scene Beside::sceneNow(const WindowState& desk) const {
    return sceneBeside(desk.scene(), desk.volume()->info, *volume_, links_);
}

void Beside::setLinks(const BesideLinks& links) {
    links_ = links;
    of_ = nullptr; // it is asked for anew
}

glm::dvec3 Beside::shift(const WindowState& desk) const {
    return volume_ && desk.volume() ? shiftBetween(desk.volume()->info, volume_->info, links_)
                                    : glm::dvec3(0);
}

bool Beside::sharesWindow(const WindowState& desk) const {
    return links_.look && volume_ && desk.volume() && desk.volume()->info.unit == volume_->info.unit;
}

SliceWish Beside::planes(const WindowState& desk) const {
    SliceWish wish = desk.slices();
    wish.placeMm += shift(desk);
    wish.labels.reset(); // they are the first scan's
    if (!sharesWindow(desk))
        wish.window = window_;
    return wish;
}

/// What belongs to the first scan's picture made this one's.
FigurePart Beside::ofThis(FigurePart part, const WindowState& desk) const {
    if (const Camera* const seen = camera())
        part.camera = *seen;
    else // before its first picture
        move(part.camera, shift(desk));
    part.orientationKnown = volume_ && volume_->info.orientationKnown;
    part.legend = part.annotations.legend && volume_ ? colourLegend(scene_, volume_->volumes)
                                                     : std::vector<LegendBar>();
    const Annotations words = desk.wordsOf(volume_.get()); // by its own phase
    part.annotations.title = words.title;
    part.annotations.caption = words.caption;
    part.annotations.arrows = words.arrows;
    part.annotations.labelLegend = part.annotations.measurements = false;
    part.labels.clear();
    part.measurements.clear();
    if (volume_) { // its scene's own words
        Annotations own = volume_->scene.annotations;
        if (const std::string phase = volume_->phaseLabel(); !phase.empty())
            own.namePhase(phase);
        for (std::string Annotations::*const text : {&Annotations::title, &Annotations::caption})
            if (!(own.*text).empty())
                part.annotations.*text = own.*text;
    }
    if (volume_ && desk.volume() &&
        placesOf(desk.volume()->info, volume_->info, links_) == BesideLinks::Places::middles)
        // they point at nothing of this scan
        part.annotations.arrows.clear();
    return part;
}

FigurePart Beside::overlay(const WindowState& desk) const {
    FigurePart part = ofThis(desk.overlay(), desk);
    part.error =
        state_.measured.empty() ? "measured error: not measured yet" : "measured error: " + state_.measured;
    return part;
}

PictureMarks Beside::marks(const WindowState& desk) const {
    return ofThis(desk.marks(), desk);
}

void Beside::saveStill(const Scene& scene, const std::filesystem::path& file, const PictureMarks& marks,
                       PanelOfStills panel) {
    state_.atRest = false; // the last state does not know of it
    viewing_->saveStill(scene, file, marks, std::move(panel));
}

bool Beside::atRest() const {
    const bool fails =
        state_.kind == ViewingState::Kind::failed || state_.kind == ViewingState::Kind::choosing;
    const std::shared_ptr<const ShownPicture> picture = viewing_->picture();
    const bool answered = (picture && picture->asked >= wished_) || state_.refused >= wished_;
    return fails || (volume_ && of_ && answered && state_.atRest);
}

std::string Beside::about(const WindowState& desk) const {
    if (state_.kind == ViewingState::Kind::failed)
        return name() + " cannot be shown: " + state_.what;
    if (state_.kind == ViewingState::Kind::choosing)
        return name() + " has several volumes: --beside takes one";
    if (!volume_ || !desk.volume())
        return name() + " is being opened";
    const VolumeInfo &of = desk.volume()->info, &other = volume_->info;
    const bool byCoordinates = placesOf(of, other, links_) == BesideLinks::Places::coordinates;
    if (byCoordinates && inOneFrame(of, other))
        return name() + ", in the same frame of reference";
    if (byCoordinates)
        return name() + "; places are linked by patient coordinates, though the scans have no common frame "
                        "of reference";
    return name() + ", middle on middle" +
           (links_.places ? "" : ": by patient coordinates the scans lie apart");
}

void besidePanel(WindowState& desk, Beside& beside) {
    wrapped("%s", beside.about(desk).c_str());
    if (!desk.volume() || !beside.volume())
        return;
    using Places = BesideLinks::Places;
    BesideLinks links = beside.links();
    const Places before = placesOf(desk.volume()->info, beside.volume()->info, links);
    bool changed = false;
    ImGui::TextUnformatted("places");
    for (const auto& [places, words] :
         {std::pair{Places::coordinates, "of the same coordinates"}, {Places::middles, "middle on middle"}})
        if (ImGui::RadioButton(words, before == places)) {
            links.places = places;
            changed = true;
        }
    changed |= ImGui::Checkbox("one function and window", &links.look);
    changed |= ImGui::Checkbox("cuts of both", &links.cuts);
    if (changed)
        beside.setLinks(links);
}

} // namespace tessera
