// bricking/export/meshes/mesh_writer.h: MeshWriter: a mesh as it is found, to a file: PLY, STL, OBJ, glTF
// (docs/formats.md, "Meshes that are written").
//
// Points go to the file at once, triangles to a temporary file without a name in its folder, which is joined
// at the end. So memory does not depend on the mesh. A disk needs room for the file and once more for its
// triangles.
#pragma once

#include "bricking/analysis/surface/surface_mesh.h" // MeshSink
#include "core/base/budget.h"
#include "core/base/output_file.h" // Existing

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// ".ply", ".stl", ".obj", ".glb".
std::vector<std::string> meshFileEndings();
/// Throws InputError naming file for another ending, as checkOutputFile() does.
void checkMeshFile(const std::filesystem::path& file, Existing existing = Existing::isReplaced);

class MeshWriter : public MeshSink {
  public:
    /// The file's format is that of its ending. Throws InputError as checkMeshFile() does and if ram cannot
    /// hold the buffers, Error if the file cannot be made.
    /// @param about  what the mesh is, for the file's comment: one line of ASCII, cut after 160 characters
    MeshWriter(const std::filesystem::path& file, const std::string& about, MemoryBudget& ram,
               Existing existing = Existing::isReplaced);
    ~MeshWriter() override;

    /// Both throw Error naming the file where it cannot be written, InputError where the mesh is more than
    /// the format can hold.
    void point(const glm::dvec3& mm) override;
    void triangle(const std::array<std::uint32_t, 3>& numbers,
                  const std::array<glm::dvec3, 3>& places) override;
    /// Joins the parts and gives the file its name; until then an earlier file stays as it is.
    /// @return its bytes
    std::uint64_t finish();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace tessera
