// datasets/torso_spine.cpp: vertebrae with arches and processes, discs, spinal canal and cord, sacrum.
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

} // namespace tessera
