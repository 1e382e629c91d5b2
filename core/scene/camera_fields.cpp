// core/scene/camera_fields.cpp: the keys of cameras, by side or spelled out: see scene_fields.h.
#include "core/base/error.h"
#include "core/scene/scene_fields.h"

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

} // namespace tessera
