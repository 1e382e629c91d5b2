// bricking/import/meshes/mesh_walk.h: walks over files of triangles before a library reads them. A walk
// allocates nothing that a file's numbers decide. All throw InputError naming file, expected and found.
#pragma once

#include "bricking/import/source/source_files.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// What a file holds, at most.
struct MeshCounts {
    std::uint64_t points = 0, triangles = 0;
    bool exact = false; // triangles: so many, not fewer
};

MeshCounts walkPly(const InputFile& file);
MeshCounts walkStl(const InputFile& file);
MeshCounts walkObj(const InputFile& file);
MeshCounts walkGltf(const InputFile& file);

/// A file from its begin to its end, through a small buffer.
class FileWalk {
  public:
    explicit FileWalk(const InputFile& file, std::uint64_t from = 0) : file_(file), next_(from) {}
    /// Fills bytes; refuses a file that ends before.
    void take(void* out, std::size_t bytes);
    /// Without its end; none behind the last. Refuses lines of more than `most` bytes.
    std::optional<std::string_view> line(std::size_t most);
    std::uint64_t left() const { return file_.sizeBytes() - at(); }
    std::uint64_t at() const { return next_ - (end_ - begin_); }

  private:
    bool fill();
    const InputFile& file_;
    std::uint64_t next_;
    std::vector<std::byte> buffer_ = std::vector<std::byte>(std::size_t{1} << 16);
    std::size_t begin_ = 0, end_ = 0;
    std::string line_;
};

/// Words between spaces.
std::vector<std::string_view> wordsOf(std::string_view line);

} // namespace tessera
