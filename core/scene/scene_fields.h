// core/scene/scene_fields.h: the keys of scenes, with a table per object, for the reader, the writer, the
// published schema, the user guide and `--set`. Include from .cpp files only.
#pragma once

#include "core/base/json_fields.h"
#include "core/base/json_schema.h"
#include "core/scene/scene.h"

namespace tessera {

const Fields<Scene>& sceneFields();
/// The keys that hold values, in the order of the tables, with their options.
const std::vector<KeyRow>& sceneKeys();
/// docs/scene.schema.json
const Schema& sceneSchema();
/// Sets one key: "shading.ambient", "isosurfaces[0].opacity". Other keys stay; missing objects, and an item
/// after the last of a list, are created. Throws InputError naming `where` for values that a scene file could
/// not have, and for unknown keys, with the nearest.
void setSceneKey(Scene& scene, const std::string& key, const nlohmann::json& value, const std::string& where);
const Fields<Shading>& shadingFields();
const Fields<Lighting>& lightingFields();
const Fields<Cuts>& cutsFields();
const Fields<Labels>& labelsFields();
const Fields<Measurement>& measurementFields();
const Fields<SceneMesh>& meshFields();
const Fields<Annotations>& annotationFields();
/// A camera by position, focal point and so on.
const Fields<Camera>& freeCameraFields();
/// By side, or by position.
Kind<CameraChoice> cameraKind();
/// true: parallel.
Kind<Projection> projectionKind();
/// Any finite numbers.
Kind<glm::dvec3> vectorKind();
/// Linear light, [0,1].
Kind<glm::dvec3> colourKind();
/// Empty, or HU.
Kind<std::string> unitKind();
/// These take what a user types, too: a name, or [centre, width]; typed "CENTRE,WIDTH".
Kind<WindowChoice> windowKind();
/// A whole number from 1 to most, or auto, which is 0; both may be typed as text.
Kind<int> numberOrAuto(int most);
/// A level of a file: a number, or auto; both may be typed as text.
Kind<int> fileLevelKind();
/// [x0, x1, y0, y1, z0, z1]; typed "X0,X1,Y0,Y1,Z0,Z1".
Kind<FileBox> fileBoxKind();
/// [width, height]; typed "WIDTHxHEIGHT".
Kind<glm::ivec2> sizeKind();
/// A colour's name, sRGB, linear light, or transparent.
Kind<std::optional<glm::vec3>> backgroundKind();

/// A transfer function as its keys: the same in scenes, paths and presets.
struct TransferKeys {
    double unitMm = 1; // opacities are of a path of this length
    std::vector<OpacityPoint> opacity;
    std::vector<ColourPoint> colour;
    std::vector<Material> materials;
    std::vector<GradientPoint> gradient;
    GradientOpacity::Per gradientPer = GradientOpacity::Per::mm;
    std::vector<Tissue> tissues;
};
const Fields<TransferKeys>& transferFields();
/// From the keys of an object; others are left to the caller. A missing unit distance is 1 mm, a missing
/// scalarOpacity is refused (it would draw nothing), missing colours are white.
TransferFunction parseTransfer(const JsonValue& whole);
/// The inverse. The function must hold opacities (fromOpacity), not extinctions.
nlohmann::json transferJson(const TransferFunction& function);
/// A preset's name, or the keys.
Kind<TransferChoice> transferKind();
const Fields<MaterialResponse>& responseFields();
const Fields<SurfaceFinish>& finishFields();
const Fields<Reflection>& reflectionFields();
const Fields<Phase>& phaseFields();

} // namespace tessera
