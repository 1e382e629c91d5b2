// bricking/export/meshes/glb_form.cpp: glTF 2.0 in one binary file: a chunk of JSON, filled with blanks as
// the format has it, and a chunk of points and triangles. Coordinates stay millimetres in patient space.
#include "bricking/export/meshes/mesh_form.h"

#include <limits>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

constexpr std::size_t kJsonBytes = 2028, kGlbHead = 12 + 8 + kJsonBytes + 8; // 4 divides them
constexpr std::uint32_t kGlb = 0x46546C67, kJson = 0x4E4F534A, kBin = 0x004E4942;

std::string glbHead(const WrittenMesh& mesh) {
    using nlohmann::json;
    const auto bounds = [](const glm::vec3& v) { return json{v.x, v.y, v.z}; };
    const json document = {
        {"asset", {{"version", "2.0"}, {"generator", "Tessera"}, {"extras", {{"about", mesh.about}}}}},
        {"scene", 0},
        {"scenes", {{{"nodes", {0}}}}},
        {"nodes", {{{"mesh", 0}}}},
        {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"mode", 4}}}}}}},
        {"accessors",
         {{{"bufferView", 0},
           {"componentType", 5126}, // float
           {"count", mesh.points},
           {"type", "VEC3"},
           {"min", bounds(mesh.low)},
           {"max", bounds(mesh.high)}},
          {{"bufferView", 1},
           {"componentType", 5125}, // unsigned, 32 bits
           {"count", 3 * mesh.triangles},
           {"type", "SCALAR"}}}},
        {"bufferViews",
         {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", mesh.pointBytes}, {"target", 34962}},
          {{"buffer", 0},
           {"byteOffset", mesh.pointBytes},
           {"byteLength", mesh.triangleBytes},
           {"target", 34963}}}},
        {"buffers", {{{"byteLength", mesh.pointBytes + mesh.triangleBytes}}}}};
    std::string text = document.dump();
    text.resize(kJsonBytes, ' ');
    const std::uint64_t body = mesh.pointBytes + mesh.triangleBytes;
    std::string head;
    appendRaw(head, kGlb);
    appendRaw(head, std::uint32_t{2});
    appendRaw(head, static_cast<std::uint32_t>(kGlbHead + body));
    appendRaw(head, static_cast<std::uint32_t>(kJsonBytes));
    appendRaw(head, kJson);
    head += text;
    appendRaw(head, static_cast<std::uint32_t>(body));
    appendRaw(head, kBin);
    return head;
}

void glbPoint(const glm::vec3& place, std::string& bytes) {
    appendRaw(bytes, place);
}

void glbTriangle(const std::array<std::uint32_t, 3>& numbers, const std::array<glm::vec3, 3>&,
                 std::string& bytes) {
    appendRaw(bytes, numbers);
}

} // namespace

const MeshForm kGlbForm{".glb",
                        kGlbHead,
                        std::numeric_limits<std::uint64_t>::max(),
                        std::numeric_limits<std::uint32_t>::max(),
                        glbHead,
                        glbPoint,
                        glbTriangle};

} // namespace tessera
