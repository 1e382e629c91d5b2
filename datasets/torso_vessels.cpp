// datasets/torso_vessels.cpp: aorta, caval veins and their branches, and the vessels of the liver.
#include "datasets/branching_tree.h"
#include "datasets/torso_parts.h"

namespace tessera {
namespace {

constexpr float kAortaHu = 350, kArteryHu = 320, kVeinHu = 165, kPortalHu = 185;

void addVeins(TorsoBuilder& torso) {
    const float v = torso.voxelMm;
    Tissue& portal = torso.add({{0, kPortalHu}}, 2);
    addTube(portal.shapes,
            {{{2, -30, -120}, 4},
             {{4, -24, -75}, 5},
             {{4, -15, -46}, 6.5F},
             {{-20, -16, -24}, 7},
             {{-46, -10, -12}, 6.5F}},
            v);
    addTube(portal.shapes, {{{4, -15, -46}, 5.5F}, {{40, 6, -27}, 4.5F}, {{84, 28, -12}, 4}}, v);
    const auto inLiver = [&](const glm::vec3& p) {
        const glm::vec3 right = (p - glm::vec3(-66, 0, -22)) / glm::vec3(50, 60, 42);
        const glm::vec3 left = (p - glm::vec3(-14, -38, -4)) / glm::vec3(44, 25, 19);
        const bool inside = glm::dot(right, right) < 1 || glm::dot(left, left) < 1;
        return inside && torso.innerWall->distance(p) < -12;
    };
    const Box box{{-125, -70, -75}, {35, 65, 40}};
    addTree(portal.shapes, growTree({-46, -10, -12}, scatter(box, 17, 41, inLiver), {6, 1.0F, 0.4F, 2.6F}),
            v);
    addTree(portal.shapes, growTree({-22, -2, 16}, scatter(box, 19, 42, inLiver), {7, 1.0F, 0.45F, 2.6F}), v);

    Tissue& veins = torso.add({{0, kVeinHu}}, 3);
    addTube(veins.shapes,
            {{{-15, 5, -90}, 9},
             {{-18, 0, -60}, 10},
             {{-20, 2, -20}, 10.5F},
             {{-22, 2, 10}, 11},
             {{-24, -10, 32}, 11},
             {{-27, -22, 48}, 11}},
            v);
    addTube(veins.shapes,
            {{{-28, -24, 78}, 9},
             {{-26, -18, 110}, 8.5F},
             {{-24, -14, 146}, 8},
             {{-32, -10, 180}, 7},
             {{-52, -8, 200}, 6.5F}},
            v);
    addTube(veins.shapes,
            {{{-24, -16, 146}, 7}, {{4, -24, 156}, 6.5F}, {{34, -14, 182}, 6.5F}, {{54, -8, 202}, 6}}, v);
    for (const float side : {-1.0F, 1.0F}) {
        addTube(veins.shapes,
                {{{-15, 5, -90}, 7},
                 {{side * 22 - 4, 12, -112}, 6.5F},
                 {{side * 46, 14, -140}, 6.5F},
                 {{side * 62, -14, -175}, 6.5F},
                 {{side * 64, -44, -216}, 6.5F}},
                v);
        addTube(veins.shapes,
                {{{-18, 2, -42}, 5}, {{side * 26 - 8, 8, -44}, 4.5F}, {{side * 50, 26, -46}, 4}}, v);
    }
}

} // namespace

const std::vector<Knot>& aortaCourse() {
    static const std::vector<Knot> course = {
        {{8, -20, 68}, 14},    {{-6, -26, 84}, 15},   {{-15, -26, 106}, 15},  {{-10, -23, 130}, 13.5F},
        {{5, -12, 143}, 12},   {{23, 7, 142}, 11.5F}, {{26, 26, 132}, 11.5F}, {{25, 37, 114}, 12},
        {{24, 34, 70}, 11.5F}, {{18, 24, 35}, 11},    {{10, 12, 8}, 10.5F},   {{5, 4, -18}, 10},
        {{3, -2, -50}, 9.5F},  {{2, -4, -86}, 9}};
    return course;
}

void addVessels(TorsoBuilder& torso) {
    addVeins(torso);
    const float v = torso.voxelMm;
    Tissue& aorta = torso.add({{0, kAortaHu}}, 2);
    addTube(aorta.shapes, aortaCourse(), v);
    Tissue& arteries = torso.add({{0, kArteryHu}}, 1.5F);
    ShapeList& a = arteries.shapes;
    addTube(a, {{{-4, -19, 143}, 6}, {{-18, -6, 172}, 5.5F}, {{-26, 4, 190}, 4.5F}, {{-58, 2, 206}, 4}}, v);
    addTube(a, {{{-22, 2, 184}, 4}, {{-19, 0, 216}, 3.6F}}, v);
    addTube(a, {{{9, -9, 148}, 4.5F}, {{14, 0, 180}, 3.8F}, {{18, 0, 216}, 3.6F}}, v);
    addTube(a, {{{23, 5, 146}, 5}, {{24, 12, 176}, 4.5F}, {{34, 8, 194}, 4.2F}, {{60, 2, 206}, 4}}, v);
    // coeliac trunk to liver and spleen, superior and inferior mesenteric
    addTube(a, {{{5, 2, -14}, 4}, {{4, -14, -18}, 4}, {{-14, -22, -20}, 3.2F}, {{-40, -18, -14}, 2.8F}}, v);
    addTube(a, {{{4, -14, -18}, 3.5F}, {{26, -4, -22}, 3}, {{52, 16, -20}, 2.8F}, {{82, 30, -8}, 2.5F}}, v);
    addTube(a, {{{4, -2, -30}, 4}, {{5, -20, -42}, 3.8F}, {{2, -27, -80}, 3.2F}, {{-14, -30, -120}, 2.2F}},
            v);
    addTube(a, {{{2, -10, -70}, 2.4F}, {{14, -14, -90}, 2}, {{34, -8, -130}, 1.6F}}, v);
    for (int k = 0; k < 6; ++k) { // jejunal and colic arcades
        const auto f = static_cast<float>(k);
        const float side = k % 2 == 0 ? 1.0F : -1.0F;
        addTube(a,
                {{{2 - 2 * f, -27, -62 - 10 * f}, 2},
                 {{side * 22, -34, -72 - 12 * f}, 1.5F},
                 {{side * 46, -36, -84 - 11 * f}, 1}},
                v);
    }
    for (const float side : {-1.0F, 1.0F}) {
        const float down = side < 0 ? -8.0F : 0.0F;
        addTube(a,
                {{{3, 0, -38}, 3.2F}, {{side * 26, 12, -41 + down}, 3}, {{side * 48, 27, -42 + down}, 2.6F}},
                v);
        addTube(a,
                {{{2, -4, -84}, 6.5F},
                 {{side * 15, -1, -104}, 6},
                 {{side * 38, 2, -130}, 5.5F},
                 {{side * 58, -20, -168}, 5},
                 {{side * 74, -48, -216}, 4.8F}},
                v);
        addTube(a,
                {{{side * 38, 2, -130}, 4.2F}, {{side * 44, 24, -152}, 3.6F}, {{side * 48, 38, -180}, 2.4F}},
                v);
    }
    // calcified plaques of the wall
    Tissue& plaques = torso.add({{0, 750}});
    for (const glm::vec3& at : {glm::vec3(11, 3, -60), glm::vec3(-5, 1, -78), glm::vec3(32, 43, 112)})
        plaques.shapes.push_back(std::make_unique<Ellipsoid>(at, glm::vec3(1.8F, 3, 4)));
}

} // namespace tessera
