// bricking/export/meshes/mesh_form.h: MeshForm: how a format of files writes a mesh: a head of a fixed
// length, points, then triangles. Internal to mesh_writer.cpp; a file each implements them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <string>
#include <type_traits>

namespace tessera {

struct WrittenMesh {
    std::uint64_t points = 0, triangles = 0;
    std::uint64_t pointBytes = 0, triangleBytes = 0;
    glm::vec3 low{0}, high{0}; // the box of the points
    std::string about;
};

struct MeshForm {
    const char* ending;
    std::size_t headBytes;
    /// Most triangles, and bytes of the file.
    std::uint64_t mostTriangles, mostBytes;
    /// Exactly headBytes.
    std::string (*head)(const WrittenMesh&);
    /// These append to bytes.
    void (*point)(const glm::vec3&, std::string& bytes);
    void (*triangle)(const std::array<std::uint32_t, 3>&, const std::array<glm::vec3, 3>&,
                     std::string& bytes);
};

extern const MeshForm kPlyForm, kStlForm, kObjForm, kGlbForm;

/// As bytes, little endian.
template <typename T> void appendRaw(std::string& bytes, const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
}

} // namespace tessera
