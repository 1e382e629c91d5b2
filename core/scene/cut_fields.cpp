// core/scene/cut_fields.cpp: the keys of cuts and of measurements: see scene_fields.h.
#include "core/scene/scene_fields.h"

#include <glm/vec2.hpp>

namespace tessera {

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
