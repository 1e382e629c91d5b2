// bricking/import/meshes/gltf_walk.cpp: a walk over glTF 2.0, text (.gltf) and binary (.glb): see
// mesh_walk.h. Every range that the document names is checked against what holds it, down to files. Source:
// Khronos Group, "glTF 2.0 Specification".
#include "bricking/import/meshes/mesh_walk.h"
#include "core/base/error.h"
#include "core/base/json_reader.h"

#include <array>
#include <limits>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;

constexpr std::size_t kMostGltfItems = 100000; // of a list
constexpr int kDeepestNode = 64;
constexpr std::uint32_t kGlb = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;

class GltfWalk {
  public:
    GltfWalk(const InputFile& file) : file_(file), where_(file.path().string()) {}

    MeshCounts counts() {
        document_ = parseStrictJson(text(), where_);
        if (!document_.is_object() ||
            member(member(document_, "asset"), "version").get<std::string>().substr(0, 2) != "2.")
            refuse("glTF 2", "another version");
        for (const char* unread : {"extensionsRequired", "images", "skins"})
            if (document_.contains(unread) && !document_[unread].empty())
                refuse(std::string("a document without ") + unread, "one with them");
        checkBuffers();
        checkViews();
        checkAccessors();
        checkNodes();
        return checkMeshes();
    }

  private:
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(where_, expected, found);
    }

    /// The document; of a binary file its first chunk, and the size of the second.
    std::string text() {
        FileWalk walk(file_);
        std::array<unsigned char, 4> begin{};
        if (file_.sizeBytes() < 20)
            refuse("glTF", std::to_string(file_.sizeBytes()) + " bytes");
        walk.take(begin.data(), 4);
        if (word(begin) != kGlb)
            return readTextFile(where_);
        const std::uint32_t version = number(walk), size = number(walk), length = number(walk);
        if (version != 2 || size != file_.sizeBytes())
            refuse("binary glTF 2 of " + std::to_string(file_.sizeBytes()) + " bytes",
                   "version " + std::to_string(version) + " of " + std::to_string(size));
        if (number(walk) != kJsonChunk || length > walk.left() || length > kMaxJsonBytes)
            refuse("a chunk of JSON first, of at most 16 MiB",
                   std::to_string(length) + " bytes of the first");
        std::string text(length, ' ');
        walk.take(text.data(), text.size());
        if (walk.left() >= 8) {
            const std::uint32_t bytes = number(walk);
            if (number(walk) != kBinChunk || bytes > walk.left())
                refuse("a binary chunk of " + std::to_string(walk.left()) + " bytes", std::to_string(bytes));
            chunk_ = bytes;
        }
        return text;
    }
    static std::uint32_t word(const std::array<unsigned char, 4>& b) {
        return b[0] | std::uint32_t{b[1]} << 8 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[3]} << 24;
    }
    static std::uint32_t number(FileWalk& walk) {
        std::array<unsigned char, 4> bytes{};
        walk.take(bytes.data(), 4);
        return word(bytes);
    }

    const json& member(const json& object, const char* key) const {
        if (!object.is_object() || !object.contains(key))
            refuse(std::string("glTF with \"") + key + "\"", "none");
        const json& value = object[key];
        if (std::string_view(key) == "version" && !value.is_string())
            refuse("a version", "none");
        return value;
    }
    std::uint64_t whole(const json& object, const char* key, std::uint64_t otherwise) const {
        if (!object.is_object())
            refuse("an object", "another value");
        if (!object.contains(key))
            return otherwise;
        if (!object[key].is_number_unsigned() || object[key].get<std::uint64_t>() > (std::uint64_t{1} << 40))
            refuse(std::string("a whole number \"") + key + "\"", object[key].dump().substr(0, 40));
        return object[key].get<std::uint64_t>();
    }
    const json& list(const char* key) const {
        static const json kNothing = json::array();
        if (!document_.contains(key))
            return kNothing;
        const json& all = document_[key];
        if (!all.is_array() || all.size() > kMostGltfItems)
            refuse(std::string("a list \"") + key + "\" of at most " + std::to_string(kMostGltfItems),
                   "another value");
        return all;
    }
    const json& item(const char* key, std::uint64_t number) const {
        const json& all = list(key);
        if (number >= all.size())
            refuse(std::string(key) + " below " + std::to_string(all.size()), std::to_string(number));
        return all[number];
    }
    static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();

    void checkBuffers() const {
        std::size_t number = 0;
        for (const json& buffer : list("buffers")) {
            const std::uint64_t bytes = whole(buffer, "byteLength", 0);
            std::uint64_t there = chunk_;
            if (buffer.contains("uri")) {
                if (!buffer["uri"].is_string())
                    refuse("a buffer's uri", "another value");
                const auto& uri = buffer["uri"].get_ref<const std::string&>();
                there = uri.starts_with("data:")
                            ? (uri.size() - std::min(uri.size(), uri.find(',') + 1)) / 4 * 3
                            : sizeBeside(uri);
            } else if (number != 0) {
                refuse("the binary chunk as the first buffer", "another one");
            }
            if (bytes > there)
                refuse("buffers of at most " + std::to_string(there) + " bytes, which are there",
                       std::to_string(bytes));
            ++number;
        }
    }
    /// Of a file in the same folder.
    std::uint64_t sizeBeside(const std::string& uri) const {
        if (uri.empty() || uri.find('/') != std::string::npos || uri.find('\\') != std::string::npos ||
            uri.find(':') != std::string::npos)
            refuse("buffers in this file, or in files of its folder",
                   "\"" + printable(uri.substr(0, 60)) + "\"");
        return InputFile(file_.path().parent_path() / uri).sizeBytes();
    }
    void checkViews() const {
        for (const json& view : list("bufferViews")) {
            const std::uint64_t size = whole(item("buffers", whole(view, "buffer", kNone)), "byteLength", 0);
            const std::uint64_t end = whole(view, "byteOffset", 0) + whole(view, "byteLength", 0);
            if (end > size || whole(view, "byteStride", 0) > 252)
                refuse("views of a buffer's " + std::to_string(size) + " bytes",
                       "one up to " + std::to_string(end));
        }
    }
    std::uint64_t itemBytes(const json& accessor) const {
        std::uint64_t bytes = 0;
        switch (whole(accessor, "componentType", 0)) {
        case 5120:
        case 5121:
            bytes = 1;
            break;
        case 5122:
        case 5123:
            bytes = 2;
            break;
        case 5125:
        case 5126:
            bytes = 4;
            break;
        default:
            refuse("a componentType of glTF", std::to_string(whole(accessor, "componentType", 0)));
        }
        const json& type = member(accessor, "type");
        for (const auto& [name, count] : {std::pair{"SCALAR", 1u},
                                          {"VEC2", 2u},
                                          {"VEC3", 3u},
                                          {"VEC4", 4u},
                                          {"MAT2", 4u},
                                          {"MAT3", 9u},
                                          {"MAT4", 16u}})
            if (type == name)
                return bytes * count;
        refuse("a type of glTF", type.dump().substr(0, 40));
    }
    void checkAccessors() const {
        for (const json& accessor : list("accessors")) {
            const std::uint64_t count = whole(accessor, "count", 0), bytes = itemBytes(accessor);
            if (!accessor.contains("bufferView") || accessor.contains("sparse"))
                refuse("accessors of a view each, none sparse", "another one");
            const json& view = item("bufferViews", whole(accessor, "bufferView", kNone));
            const std::uint64_t size = whole(view, "byteLength", 0);
            const std::uint64_t stride = whole(view, "byteStride", bytes),
                                from = whole(accessor, "byteOffset", 0);
            if (count == 0 || stride == 0 || from > size || count - 1 > size / stride ||
                from + (count - 1) * stride + bytes > size)
                refuse("accessors of at most a view's " + std::to_string(size) + " bytes",
                       std::to_string(count) + " items of " + std::to_string(bytes));
        }
    }
    /// Nodes are trees: what reads them follows their children.
    void checkNodes() const {
        std::vector<bool> isChild(list("nodes").size(), false);
        for (const json& node : list("nodes")) {
            if (node.is_object() && node.contains("mesh"))
                item("meshes", whole(node, "mesh", kNone));
            for (const std::uint64_t child : children(node)) {
                item("nodes", child);
                if (isChild[child])
                    refuse("nodes with one parent at most", "node " + std::to_string(child) + " with two");
                isChild[child] = true;
            }
        }
        for (std::uint64_t n = 0; n < isChild.size(); ++n)
            if (!isChild[n])
                checkDepth(n, 0);
        std::uint64_t reached = 0; // nodes that no root leads to form rings
        for (std::uint64_t n = 0; n < isChild.size(); ++n)
            if (!isChild[n])
                reached += size(n);
        if (reached != isChild.size())
            refuse("nodes that are trees", "a ring of nodes");
        if (document_.contains("scene"))
            item("scenes", whole(document_, "scene", 0));
        for (const json& scene : list("scenes"))
            if (scene.is_object() && scene.contains("nodes"))
                for (const json& root : scene["nodes"]) {
                    if (!root.is_number_unsigned())
                        refuse("numbers of nodes", root.dump().substr(0, 40));
                    item("nodes", root.get<std::uint64_t>());
                }
    }
    std::vector<std::uint64_t> children(const json& node) const {
        std::vector<std::uint64_t> numbers;
        if (!node.is_object() || !node.contains("children"))
            return numbers;
        for (const json& child : node["children"]) {
            if (!child.is_number_unsigned())
                refuse("numbers of nodes", child.dump().substr(0, 40));
            numbers.push_back(child.get<std::uint64_t>());
        }
        return numbers;
    }
    void checkDepth(std::uint64_t node, int depth) const {
        if (depth > kDeepestNode)
            refuse("nodes at most " + std::to_string(kDeepestNode) + " deep", "deeper ones");
        for (const std::uint64_t child : children(item("nodes", node)))
            checkDepth(child, depth + 1);
    }
    std::uint64_t size(std::uint64_t node) const {
        std::uint64_t all = 1;
        for (const std::uint64_t child : children(item("nodes", node)))
            all += size(child);
        return all;
    }
    MeshCounts checkMeshes() const {
        MeshCounts counts;
        std::vector<MeshCounts> ofMesh;
        for (const json& mesh : list("meshes")) {
            MeshCounts here;
            for (const json& primitive : member(mesh, "primitives")) {
                if (whole(primitive, "mode", 4) < 4) // points and lines
                    continue;
                const json& attributes = member(primitive, "attributes");
                for (const auto& [name, accessor] : attributes.items()) {
                    if (!accessor.is_number_unsigned())
                        refuse("numbers of accessors", accessor.dump().substr(0, 40));
                    item("accessors", accessor.get<std::uint64_t>());
                }
                const json& position = item("accessors", whole(attributes, "POSITION", kNone));
                if (position["type"] != "VEC3" || position["componentType"] != 5126)
                    refuse("positions of three floats", "others");
                const std::uint64_t points = whole(position, "count", 0);
                std::uint64_t corners = points;
                if (primitive.contains("indices")) {
                    const json& indices = item("accessors", whole(primitive, "indices", kNone));
                    const std::uint64_t type = whole(indices, "componentType", 0);
                    if (indices["type"] != "SCALAR" || (type != 5121 && type != 5123 && type != 5125))
                        refuse("indices of whole numbers", "others");
                    corners = whole(indices, "count", 0);
                }
                for (const auto& [name, accessor] : attributes.items())
                    if (whole(item("accessors", accessor.get<std::uint64_t>()), "count", 0) != points)
                        refuse("as many of " + printable(name) + " as positions", "others");
                here.points += points;
                here.triangles += whole(primitive, "mode", 4) == 4 ? corners / 3 : corners;
            }
            ofMesh.push_back(here);
        }
        for (const json& node : list("nodes"))
            if (node.contains("mesh")) {
                const MeshCounts& here = ofMesh[node["mesh"].get<std::uint64_t>()];
                counts.points += here.points;
                counts.triangles += here.triangles;
            }
        return counts;
    }

    const InputFile& file_;
    std::string where_;
    json document_;
    std::uint64_t chunk_ = 0; // bytes
};

} // namespace

MeshCounts walkGltf(const InputFile& file) {
    return GltfWalk(file).counts();
}

} // namespace tessera
