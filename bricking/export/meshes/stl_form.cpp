// bricking/export/meshes/stl_form.cpp: STL, binary: triangles with their normals and corners, no points.
#include "bricking/export/meshes/mesh_form.h"

#include <glm/geometric.hpp>
#include <limits>

namespace tessera {
namespace {

constexpr std::size_t kStlText = 80, kStlHead = kStlText + sizeof(std::uint32_t);

std::string stlHead(const WrittenMesh& mesh) {
    std::string head = mesh.about; // never "solid": that begins a text file
    head.resize(kStlText, ' ');
    appendRaw(head, static_cast<std::uint32_t>(mesh.triangles));
    return head;
}

void stlPoint(const glm::vec3&, std::string&) {}

void stlTriangle(const std::array<std::uint32_t, 3>&, const std::array<glm::vec3, 3>& places,
                 std::string& bytes) {
    const glm::dvec3 normal = glm::cross(glm::dvec3(places[1]) - glm::dvec3(places[0]),
                                         glm::dvec3(places[2]) - glm::dvec3(places[0]));
    const double length = glm::length(normal);
    appendRaw(bytes, length > 0 ? glm::vec3(normal / length) : glm::vec3(0));
    appendRaw(bytes, places);
    appendRaw(bytes, std::uint16_t{0});
}

} // namespace

const MeshForm kStlForm{".stl",
                        kStlHead,
                        std::numeric_limits<std::uint32_t>::max(),
                        std::numeric_limits<std::uint64_t>::max(),
                        stlHead,
                        stlPoint,
                        stlTriangle};

} // namespace tessera
