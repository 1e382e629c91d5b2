// bricking/export/meshes/ply_form.cpp: PLY, binary, little endian. Blanks in a comment fill the head.
#include "bricking/export/meshes/mesh_form.h"

#include <limits>

namespace tessera {
namespace {

constexpr std::size_t kPlyHead = 512;

std::string plyHead(const WrittenMesh& mesh) {
    std::string before = "ply\nformat binary_little_endian 1.0\ncomment " + mesh.about + "\ncomment ";
    const std::string after =
        "\nelement vertex " + std::to_string(mesh.points) +
        "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
        std::to_string(mesh.triangles) + "\nproperty list uchar " +
        (mesh.points > std::uint64_t{std::numeric_limits<std::int32_t>::max()} ? "uint" : "int") +
        " vertex_indices\nend_header\n";
    before.resize(kPlyHead - after.size(), ' ');
    return before + after;
}

void plyPoint(const glm::vec3& place, std::string& bytes) {
    appendRaw(bytes, place);
}

void plyTriangle(const std::array<std::uint32_t, 3>& numbers, const std::array<glm::vec3, 3>&,
                 std::string& bytes) {
    bytes.push_back('\3');
    appendRaw(bytes, numbers);
}

} // namespace

const MeshForm kPlyForm{".ply",
                        kPlyHead,
                        std::numeric_limits<std::uint64_t>::max(),
                        std::numeric_limits<std::uint64_t>::max(),
                        plyHead,
                        plyPoint,
                        plyTriangle};

} // namespace tessera
