// bricking/export/meshes/obj_form.cpp: OBJ: text, nine digits a number, from which the same float is read.
#include "bricking/export/meshes/mesh_form.h"

#include <cstdio>
#include <limits>

namespace tessera {
namespace {

constexpr std::size_t kObjHead = 256;

std::string objHead(const WrittenMesh& mesh) {
    std::string head = "# " + mesh.about + "\n# " + std::to_string(mesh.points) + " points, " +
                       std::to_string(mesh.triangles) + " triangles";
    head.resize(kObjHead - 1, ' ');
    return head + "\n";
}

void objPoint(const glm::vec3& place, std::string& bytes) {
    char line[64];
    bytes.append(line, static_cast<std::size_t>(std::snprintf(
                           line, sizeof line, "v %.9g %.9g %.9g\n", static_cast<double>(place.x),
                           static_cast<double>(place.y), static_cast<double>(place.z))));
}

void objTriangle(const std::array<std::uint32_t, 3>& numbers, const std::array<glm::vec3, 3>&,
                 std::string& bytes) {
    char line[64]; // numbers count from 1
    bytes.append(line, static_cast<std::size_t>(std::snprintf(line, sizeof line, "f %llu %llu %llu\n",
                                                              numbers[0] + 1ull, numbers[1] + 1ull,
                                                              numbers[2] + 1ull)));
}

} // namespace

const MeshForm kObjForm{".obj",
                        kObjHead,
                        std::numeric_limits<std::uint64_t>::max(),
                        std::numeric_limits<std::uint64_t>::max(),
                        objHead,
                        objPoint,
                        objTriangle};

} // namespace tessera
