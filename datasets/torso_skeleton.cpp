// datasets/torso_skeleton.cpp: vertebrae with arches and processes, discs, spinal canal and cord, sacrum.
// Ribs with their cartilage, sternum, shoulder girdle and pelvis: cortex outside, marrow inside.
#include "datasets/torso_parts.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr float kSpongyHu = 240, kDiscHu = 90;
constexpr float kSpineTop = 203;

float vertebraPitch(int i) { // height of a vertebra with its disc; 0 is the first thoracic
    const auto f = static_cast<float>(i);
    return i < kThoracic ? 14.0F + 0.36F * f : 22.0F + 0.5F * (f - kThoracic);
}

glm::vec3 spineDirection(float z) {
    return glm::normalize(spineMiddle(z + 5) - spineMiddle(z - 5));
}

void addVertebra(ShapeList& bodies, ShapeList& arches, int i, float voxelMm) {
    const float z = vertebraZ(i);
    const glm::vec3 c = spineMiddle(z), half = vertebraHalf(i);
    const glm::mat3 axes = axesAlong(spineDirection(z));
    const auto at = [&](float x, float back, float up) { return c + axes * glm::vec3(x, back, up); };
    const bool thoracic = i < kThoracic;
    bodies.push_back(std::make_unique<Drum>(c, half, 0.1F, axes));

    const float canal = half.y + 8; // middle of the spinal canal behind the middle of the body
    const float drop = thoracic ? -12.0F - 4.0F * std::sin(0.26F * static_cast<float>(i)) : -3.0F;
    const float tipBack = canal + (thoracic ? 25.0F : 29.0F);
    for (const float side : {-1.0F, 1.0F}) {
        const auto tube = [&](const glm::vec3& a, const glm::vec3& b, float ra, float rb) {
            arches.push_back(std::make_unique<TubeSegment>(a, b, ra, rb, voxelMm));
        };
        const float up = 0.25F * half.z;
        const glm::vec3 pedicle = at(side * 10.5F, half.y - 3, up), pillar = at(side * 12, canal + 1, up - 1);
        tube(pedicle, pillar, 3.6F, 4.2F);
        tube(pillar, at(side * 2, canal + 10, -3), 3.4F, 3.2F); // lamina
        tube(pillar,
             at(side * (thoracic ? 27.0F : 36.0F), canal + (thoracic ? 9.0F : 3.0F), thoracic ? 3.0F : 1.0F),
             3.4F, thoracic ? 3.4F : 2.4F); // transverse process
        tube(at(side * 13, canal + 3, up), at(side * 13, canal + 5, 0.72F * vertebraPitch(i)), 4,
             2.6F); // facets
        tube(at(side * 12, canal + 5, up), at(side * 12, canal + 7, -0.55F * vertebraPitch(i)), 3.6F, 2.8F);
    }
    const glm::vec3 base = at(0, canal + 9, -2), tip = at(0, tipBack, drop);
    const float tall = thoracic ? 4.5F : 8.0F;
    arches.push_back(std::make_unique<FlatSegment>(base, tip, tall, tall / 2.6F, glm::vec3(1, 0, 0)));
}

} // namespace

glm::vec3 spineMiddle(float z) {
    // thoracic kyphosis above, lumbar lordosis below
    static const std::vector<Knot> kCurve = curveThrough({{{0, 30, -130}, 0},
                                                          {{0, 24, -100}, 0},
                                                          {{0, 22, -70}, 0},
                                                          {{0, 28, -20}, 0},
                                                          {{0, 38, 30}, 0},
                                                          {{0, 45, 80}, 0},
                                                          {{0, 45, 125}, 0},
                                                          {{0, 38, 170}, 0},
                                                          {{0, 28, 216}, 0}},
                                                         2);
    std::size_t i = 0;
    while (i + 2 < kCurve.size() && kCurve[i + 1].at.z < z)
        ++i;
    const glm::vec3 &a = kCurve[i].at, &b = kCurve[i + 1].at;
    return a + (z - a.z) / (b.z - a.z) * (b - a);
}

float vertebraZ(int i) {
    float top = kSpineTop;
    for (int k = 0; k < i; ++k)
        top -= vertebraPitch(k);
    return top - 0.5F * vertebraPitch(i);
}

glm::vec3 vertebraHalf(int i) {
    const float f = static_cast<float>(i) / (kVertebrae - 1);
    return {12.5F + 9.5F * f, 9.5F + 6.0F * f, 0.39F * vertebraPitch(i)};
}

void addSpine(TorsoBuilder& torso) {
    Tissue& discs = torso.add({{0, kDiscHu}});
    for (int i = 0; i < kVertebrae; ++i) {
        const float z = vertebraZ(i) - 0.5F * vertebraPitch(i);
        glm::vec3 half = vertebraHalf(i);
        half.z = 0.16F * vertebraPitch(i);
        discs.shapes.push_back(
            std::make_unique<Drum>(spineMiddle(z), half, 0.0F, axesAlong(spineDirection(z))));
    }
    Tissue& arches = torso.add({{0, kCortexHu}, {-1.7F, kMarrowHu}}, 2);
    Tissue& bodies =
        torso.add({{0, 0.8F * kCortexHu}, {-1.5F, kSpongyHu}}); // last: they keep their back wall
    for (int i = 0; i < kVertebrae; ++i)
        addVertebra(bodies.shapes, arches.shapes, i, torso.voxelMm);
    Tissue& sacrum = torso.add({{0, 0.85F * kCortexHu}, {-1.8F, kMarrowHu}}, 9);
    const auto sacral = [&](float y, float z, float width, float depth, float height, float lean) {
        sacrum.shapes.push_back(std::make_unique<Ellipsoid>(
            glm::vec3(0, y, z), glm::vec3(width, depth, height), axesAlong({0, lean, 1})));
    };
    sacral(43, -119, 24, 17, 13, -0.45F);
    sacral(53, -127, 51, 11, 15, -0.45F);
    sacral(61, -145, 38, 10, 14, -0.4F);
    sacral(68, -163, 27, 8, 12, -0.15F);
    sacral(69, -180, 18, 7, 11, 0.2F);
    sacral(63, -196, 9, 5, 9, 0.6F);
    for (int k = 0; k < 4; ++k) { // median crest
        const auto f = static_cast<float>(k);
        sacrum.shapes.push_back(
            std::make_unique<Ellipsoid>(glm::vec3(0, 68 + 4 * f, -122 - 15 * f), glm::vec3(3, 9, 6)));
    }

    Tissue& canal = torso.add({{0, 12}});
    Tissue& cord = torso.add({{0, 42}});
    std::vector<Knot> course, cordCourse;
    for (int i = -1; i < kVertebrae; ++i) {
        const float z = i < 0 ? kSpineTop + 12 : vertebraZ(i);
        const glm::vec3 half = vertebraHalf(std::max(i, 0));
        course.push_back({spineMiddle(z) + axesAlong(spineDirection(z))[1] * (half.y + 8), 7.2F});
        if (i <= kThoracic)
            cordCourse.push_back({course.back().at, i == kThoracic ? 2.0F : 4.4F});
    }
    course.push_back({{0, 62, -132}, 6});
    course.push_back({{0, 68, -160}, 4});
    addTube(canal.shapes, course, torso.voxelMm, 6);
    addTube(cord.shapes, cordCourse, torso.voxelMm, 6);
}

namespace {

constexpr float kCartilageHu = 115;

void addRibs(TorsoBuilder& torso) {
    Tissue& cartilage = torso.add({{0, kCartilageHu}});
    Tissue& ribs = torso.add({{0, kCortexHu}, {-1.4F, kMarrowHu}});
    const Loft& wall = *torso.innerWall;
    for (const float side : {-1.0F, 1.0F})
        for (int i = 0; i < kThoracic; ++i) {
            const auto f = static_cast<float>(i);
            const float zBack = vertebraZ(i) + 4;
            const float drop = i == 0   ? 26.0F
                               : i < 8  ? 40 + 6 * f
                               : i < 10 ? 82.0F
                                        : 30.0F + 12.0F * (11 - f);
            const float last = i == 0   ? 148.0F
                               : i < 7  ? 146 - 3 * f
                               : i < 10 ? 122 - 7 * (f - 7)
                                        : 82 - 22 * (f - 10);
            const glm::vec3 head = spineMiddle(zBack) + glm::vec3(side * (vertebraHalf(i).x + 1), 9, 0);
            const glm::vec3 neck = spineMiddle(zBack) + glm::vec3(side * (vertebraHalf(i).x + 15), 19, 1);
            std::vector<glm::vec3> points = {head, neck};
            const float firstAngle = i == 0 ? 48.0F : 32.0F;
            for (float angle = firstAngle; angle <= last; angle += 5) {
                const float t = (angle - firstAngle) / (146 - firstAngle);
                // little fall near the spine, most of it along the side
                points.push_back(wall.wallPoint(angle, zBack - drop * t * (0.55F + 0.45F * t), 4));
                points.back().x *= side;
            }
            const float tall = i == 0 ? 5.5F : i > 9 ? 4.6F : 5.8F;
            std::vector<Knot> course;
            for (const glm::vec3& p : points)
                course.push_back({p, tall});
            course = curveThrough(course, 4);
            for (std::size_t k = 0; k + 1 < course.size(); ++k) {
                const glm::vec3 middle = 0.5F * (course[k].at + course[k + 1].at);
                const glm::vec3 along = glm::normalize(course[k + 1].at - course[k].at);
                glm::vec3 outward = glm::vec3(middle.x / 1.6F, middle.y - 5, 0);
                outward = glm::normalize(outward - glm::dot(outward, along) * along);
                ribs.shapes.push_back(std::make_unique<FlatSegment>(course[k].at, course[k + 1].at, tall,
                                                                    tall / 3.2F, outward));
            }
            if (i >= 10)
                continue; // floating ribs end free
            const glm::vec3 end = course.back().at;
            if (i < 7) {
                const float zSternum = 160 - 18.5F * f;
                const glm::vec3 notch = wall.wallPoint(180 - (i == 0 ? 16.0F : 9.0F), zSternum, 4);
                const glm::vec3 meets(side * (i == 0 ? 17.0F : 12.0F), notch.y, zSternum);
                glm::vec3 bend = 0.5F * (end + meets);
                bend.z = std::min(end.z, zSternum) - (i > 2 ? 3.0F * (f - 2) : 0);
                bend.y = wall.wallPoint(155, bend.z, 5).y;
                addTube(cartilage.shapes, {{end, 4.6F}, {bend, 4.8F}, {meets, 4.6F}}, torso.voxelMm, 5);
            } else { // the costal arch: up along the margin to the cartilage above
                const glm::vec3 p = wall.wallPoint(last + 14, end.z + 6, 4);
                const glm::vec3 q = wall.wallPoint(last + 26, end.z + 24, 4);
                addTube(cartilage.shapes, {{end, 4.2F}, {mirrored(p, side), 4.2F}, {mirrored(q, side), 4}},
                        torso.voxelMm, 5);
            }
        }
}

void addSternumAndGirdle(TorsoBuilder& torso) {
    Tissue& bones = torso.add({{0, kCortexHu}, {-1.5F, kMarrowHu}}, 3);
    const Loft& wall = *torso.innerWall;
    const auto front = [&](float z) { return glm::vec3(0, wall.wallPoint(180, z, 5).y, z); };
    const glm::vec3 thin(0, 1, 0.15F);
    const auto plate = [&](float z0, float z1, float width, float thickness) {
        bones.shapes.push_back(std::make_unique<FlatSegment>(front(z0), front(z1), width, width / thickness,
                                                             glm::normalize(thin)));
    };
    plate(164, 152, 17, 5);
    plate(150, 137, 13, 5);
    for (int k = 0; k < 8; ++k) {
        const auto f = static_cast<float>(k);
        plate(132 - 11 * f, 121 - 11 * f, 11 + (k == 5 ? 2.0F : 0.0F), 4.6F);
    }
    plate(42, 24, 5, 2.6F); // xiphoid
    Tissue& girdle = torso.add({{0, kCortexHu}, {-1.6F, kMarrowHu}}, 4);
    Tissue& humerus = torso.add({{0, kCortexHu}, {-1.8F, kMarrowHu}});
    for (const float side : {-1.0F, 1.0F}) {
        addTube(girdle.shapes,
                {{{side * 17, -60, 169}, 7},
                 {{side * 50, -58, 176}, 5.2F},
                 {{side * 92, -22, 188}, 4.8F},
                 {{side * 122, 14, 190}, 6}},
                torso.voxelMm, 5);
        // scapula: blade, spine with acromion, coracoid, lateral border; head of the humerus
        const glm::vec3 normal = glm::normalize(glm::vec3(side * 0.42F, 0.9F, 0.1F));
        const glm::vec3 along = glm::normalize(glm::vec3(side * -0.1F, 0, 1) -
                                               normal * glm::dot(normal, glm::vec3(side * -0.1F, 0, 1)));
        const glm::mat3 axes(glm::cross(normal, along), normal, along);
        girdle.shapes.push_back(
            std::make_unique<Ellipsoid>(glm::vec3(side * 88, 79, 128), glm::vec3(30, 2.6F, 52), axes));
        addTube(girdle.shapes,
                {{{side * 66, 88, 158}, 3},
                 {{side * 95, 82, 170}, 4},
                 {{side * 122, 56, 184}, 5.5F},
                 {{side * 130, 30, 192}, 6}},
                torso.voxelMm, 6);
        addTube(girdle.shapes,
                {{{side * 84, 82, 80}, 4}, {{side * 104, 66, 130}, 4.2F}, {{side * 112, 46, 166}, 8}},
                torso.voxelMm, 6);
        addTube(girdle.shapes, {{{side * 108, 42, 178}, 5}, {{side * 103, 8, 182}, 4.5F}}, torso.voxelMm, 6);
        humerus.shapes.push_back(
            std::make_unique<Ellipsoid>(glm::vec3(side * 124, 30, 165), glm::vec3(17, 17, 18)));
    }
}

void addPelvis(TorsoBuilder& torso) {
    Tissue& wings = torso.add({{0, kCortexHu}, {-1.6F, kMarrowHu}}, 7);
    Tissue& femur = torso.add({{0, kCortexHu}, {-2, kMarrowHu}}, 5);
    for (const float side : {-1.0F, 1.0F}) {
        // the wing: a fan of flat bars between the crest and the hip joint
        const std::vector<Knot> crest = curveThrough({{{side * 50, 62, -130}, 6.5F},
                                                      {{side * 70, 52, -112}, 5.5F},
                                                      {{side * 100, 27, -107}, 5},
                                                      {{side * 120, -8, -120}, 5.5F},
                                                      {{side * 120, -34, -141}, 6}},
                                                     5);
        for (std::size_t k = 0; k < crest.size(); ++k) {
            const float t = static_cast<float>(k) / static_cast<float>(crest.size() - 1);
            const glm::vec3 foot(side * (76 + 12 * t), 26 - 34 * t, -178);
            const glm::vec3 along = glm::normalize(foot - crest[k].at);
            const glm::vec3 beside =
                k + 1 < crest.size() ? crest[k + 1].at - crest[k].at : crest[k].at - crest[k - 1].at;
            wings.shapes.push_back(std::make_unique<FlatSegment>(crest[k].at, foot, 9.0F, 9.0F / 3.2F,
                                                                 glm::normalize(glm::cross(along, beside))));
        }
        addTube(wings.shapes, crest, torso.voxelMm, 5);
        addTube(wings.shapes,
                {{{side * 50, 62, -128}, 8},
                 {{side * 54, 54, -150}, 9},
                 {{side * 70, 28, -174}, 11},
                 {{side * 84, 6, -190}, 14}},
                torso.voxelMm, 5);
        addTube(wings.shapes,
                {{{side * 120, -34, -141}, 6}, {{side * 104, -24, -166}, 8}, {{side * 86, -10, -188}, 13}},
                torso.voxelMm, 5);
        addTube(wings.shapes,
                {{{side * 78, -22, -194}, 9}, {{side * 52, -46, -204}, 7.5F}, {{side * 20, -56, -210}, 8}},
                torso.voxelMm, 5);
        addTube(wings.shapes, {{{side * 84, 20, -192}, 13}, {{side * 76, 34, -212}, 11}}, torso.voxelMm, 5);
        femur.shapes.push_back(
            std::make_unique<Ellipsoid>(glm::vec3(side * 98, 0, -203), glm::vec3(19, 19, 19)));
        addTube(femur.shapes, {{{side * 102, 2, -206}, 14}, {{side * 126, 8, -216}, 14}}, torso.voxelMm, 6);
    }
}

} // namespace

void addRibsAndGirdles(TorsoBuilder& torso) {
    addRibs(torso);
    addSternumAndGirdle(torso);
    addPelvis(torso);
}

} // namespace tessera
