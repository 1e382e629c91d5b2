// core/scene/view_fields.cpp: the keys of cameras, by side or spelled out, of cuts and of measurements: see
// scene_fields.h.
#include "core/base/error.h"
#include "core/scene/scene_fields.h"

#include <glm/vec2.hpp>

namespace tessera {
namespace {

/// A side's name, or degrees.
Field<FittedView> sideField() {
    const Kind<ViewAngles> angles = numbersAt<ViewAngles>(&ViewAngles::turn, &ViewAngles::rise);
    const Kind<View> side = named<View>();
    return {"view",
            "Side of the patient that faces the viewer, or two angles in degrees: about the patient's axis "
            "(0 anterior, 90 left), and up towards the head.",
            [=](const JsonValue& value, FittedView& view) {
                if (value.isList()) {
                    const ViewAngles read = angles.read(value);
                    view.angles = checkedAngles(read.turn, read.rise, value.place());
                } else {
                    view.view = side.read(value);
                }
                view.named = true;
            },
            [=](const FittedView& view) {
                return view.angles ? angles.write(*view.angles) : side.write(view.view);
            },
            [=](Schema& parts) {
                return Schema{{"anyOf", {side.schema(parts), angles.schema(parts)}}};
            }};
}

const Fields<FittedView>& fittedFields() {
    static const Fields<FittedView> fields = [] {
        Fields<FittedView> f("fittedCamera");
        f.describe({{"anyOf", {{{"required", {"view"}}}, {{"required", {"mmPerPixel"}}}}}});
        f.add(sideField()).withoutDefault();
        f.add("mmPerPixel", &FittedView::mmPerPixel, numberIn(kLeastMmPerPixel, kMostMmPerPixel),
              "Edge of a pixel of a parallel projection, mm. Without \"view\": of a slice seen along its "
              "normal.")
            .writtenIf([](const FittedView& view) { return view.mmPerPixel > 0; });
        f.add("fit", &FittedView::fit, named<Fit>(),
              "The region to which the camera is fitted: everything visible under the transfer function and "
              "the isosurfaces, the volume's box, or the visible part within the cuts.");
        f.add("parallelProjection", &FittedView::projection, projectionKind(), "false: perspective.");
        return f;
    }();
    return fields;
}

CameraChoice readCamera(const JsonValue& value) {
    std::vector<std::string> known = fittedFields().keys();
    for (const std::string& key : freeCameraFields().keys())
        if (key != "parallelProjection")
            known.push_back(key);
    value.requireKeys(known);
    FittedView view;
    fittedFields().readKnown(value, view);
    if (view.mmPerPixel > 0 && view.projection != Projection::parallel)
        throw badFile(value.place(), "\"parallelProjection\": true beside \"mmPerPixel\"", "perspective");
    if (!view.named && value.has("fit"))
        throw badFile(value.place(), "\"view\" beside \"fit\"", "none");
    if (!view.named && view.mmPerPixel == 0) {
        Camera camera;
        freeCameraFields().readKnown(value, camera);
        return camera;
    }
    for (const std::string& key : freeCameraFields().keys())
        if (value.has(key) && key != "parallelProjection")
            throw view.named ? badFile(value.place(), "either \"view\" or \"position\" and its companions",
                                       "\"view\" and \"" + key + "\"")
                             : badFile(value.place(), "\"view\" beside \"mmPerPixel\"", "\"" + key + "\"");
    return view;
}

} // namespace

const Fields<Camera>& freeCameraFields() {
    static const Fields<Camera> fields = [] {
        Fields<Camera> f("freeCamera", "A camera in patient space, with VTK's parameters.");
        f.add("position", &Camera::position, vectorKind(), "Position of the eye, mm.").required();
        f.add("focalPoint", &Camera::focalPoint, vectorKind(), "Point that the camera looks at, mm.")
            .required();
        f.add("viewUp", &Camera::viewUp, vectorKind(), "Direction that points up in the picture.");
        f.add("viewAngle", &Camera::viewAngle, anyNumber(),
              "Full vertical angle in degrees, above 0 and below 180; perspective only.");
        f.add("parallelProjection", &Camera::projection, projectionKind(), "false: perspective.");
        f.add("parallelScale", &Camera::parallelScale, anyNumber(),
              "Half the height of the view in mm, above 0; parallel projection only.");
        f.rule([](const JsonValue& whole, const Camera& camera) { camera.validate(whole.place()); });
        return f;
    }();
    return fields;
}

Kind<CameraChoice> cameraKind() {
    return {
        readCamera,
        [](const CameraChoice& choice) {
            const auto* const view = std::get_if<FittedView>(&choice);
            return view ? fittedFields().write(*view) : freeCameraFields().write(std::get<Camera>(choice));
        },
        [](Schema& parts) {
            return Schema{{"oneOf", {fittedFields().reference(parts), freeCameraFields().reference(parts)}}};
        }};
}

template <> const NameTable<Keep>& namesOf<Keep>() {
    static const NameTable<Keep> names{{{Keep::inside, "inside"}, {Keep::outside, "outside"}}};
    return names;
}
template <> const NameTable<CropBox::Space>& namesOf<CropBox::Space>() {
    static const NameTable<CropBox::Space> names{
        {{CropBox::Space::patient, "patient"}, {CropBox::Space::voxels, "voxels"}}};
    return names;
}

namespace {

const Fields<CropBox>& cropBoxFields() {
    static const Fields<CropBox> fields = [] {
        Fields<CropBox> f("cropBox");
        f.add("low", &CropBox::low, vectorKind(), "Lower corner.").required();
        f.add("high", &CropBox::high, vectorKind(), "Upper corner.").required();
        f.add("space", &CropBox::space, named<CropBox::Space>(),
              "Space of the corners: the patient's (mm), or the volume's (voxels, from 0).")
            .unlessDefault();
        f.add("keep", &CropBox::keep, named<Keep>(), "Part of the volume that is drawn.");
        f.rule([](const JsonValue& whole, const CropBox& box) { checkBox(box, whole.place()); });
        return f;
    }();
    return fields;
}

const Fields<CutPlane>& cutPlaneFields() {
    static const Fields<CutPlane> fields = [] {
        Fields<CutPlane> f("cutPlane");
        f.add("point", &CutPlane::point, vectorKind(), "A point on the plane, mm.").required();
        f.add("normal", &CutPlane::normal, vectorKind(), "Normal, towards the inside.").required();
        f.add("keep", &CutPlane::keep, named<Keep>(), "Part of the volume that is drawn.");
        f.rule([](const JsonValue& whole, const CutPlane& plane) { checkPlane(plane, whole.place()); });
        return f;
    }();
    return fields;
}

const Fields<Scissors>& scissorsFields() {
    static const Fields<Scissors> fields = [] {
        Fields<Scissors> f(
            "scissors",
            "Everything that a camera sees through an outline drawn on its picture, at any distance.");
        f.add("camera", &Scissors::camera, objectOf(freeCameraFields()), "Camera of the picture.").required();
        f.add("aspect", &Scissors::aspect, anyNumber().described({{"exclusiveMinimum", 0}}),
              "Width / height of the camera's picture.");
        f.add("outline", &Scissors::outline,
              listOf(numbersAt<glm::dvec2>(&glm::dvec2::x, &glm::dvec2::y), Cuts::kMostPoints, "points")
                  .described({{"minItems", 3}}),
              "A polygon; x to the right, y down, from 0 to 1 over the picture.")
            .required();
        f.add("keep", &Scissors::keep, named<Keep>(), "Part of the volume that is drawn.");
        f.rule([](const JsonValue& whole, const Scissors& cut) { checkScissors(cut, whole.place()); });
        return f;
    }();
    return fields;
}

template <typename Cut> Kind<std::vector<Cut>> cutsOf(const Fields<Cut>& fields, const std::string& what) {
    return listOf(objectOf(fields), Cuts::kMostOfAKind, what);
}

} // namespace

const Fields<Cuts>& cutsFields() {
    static const Fields<Cuts> fields = [] {
        Fields<Cuts> f("cuts", "Cuts through the volume; the part that every cut keeps is drawn. Gradients "
                               "and light per voxel are those of the uncut volume.");
        f.add("boxes", &Cuts::boxes, cutsOf(cropBoxFields(), "boxes"),
              "Boxes along the patient's or the volume's axes.")
            .unlessDefault();
        f.add("planes", &Cuts::planes, cutsOf(cutPlaneFields(), "planes"), "Half-spaces.").unlessDefault();
        f.add("scissors", &Cuts::scissors, cutsOf(scissorsFields(), "scissors"),
              "Outlines on the pictures of cameras.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

const Fields<Measurement>& measurementFields() {
    static const Fields<Measurement> fields = [] {
        constexpr double kMostMm = 1e7;
        Fields<Measurement> f("measurement");
        f.add("kind", &Measurement::kind, named<MeasurementKind>(), "Kind of measurement.").required();
        f.add("points", &Measurement::points,
              listOf(numbersWithin<glm::dvec3>(-kMostMm, kMostMm, "[x, y, z]", &glm::dvec3::x, &glm::dvec3::y,
                                               &glm::dvec3::z),
                     2, 3, "2 or 3 points"),
              "Points in patient space (LPS), mm. Distance: both ends. Angle: an end, the corner, the other "
              "end. Circle: three points on it.")
            .required()
            .allowedBy([](const Measurement& m, const JsonValue& whole) {
                const JsonValue points = whole.at("points");
                if (!points.isList() || points.items().size() != pointsOf(m.kind))
                    points.refuse(std::to_string(pointsOf(m.kind)) + " points [x, y, z]");
            });
        return f;
    }();
    return fields;
}

} // namespace tessera
