// viewer/cli/redraw/find_data.cpp: see find_data.h.
#include "viewer/cli/redraw/find_data.h"

#include "bricking/store/store_reader.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/shown_text.h"
#include "viewer/cli/input/import_cache.h"
#include "viewer/cli/input/label_input.h"
#include "viewer/cli/input/remote_input.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/session/file_kind.h"

#include <algorithm>
#include <cctype>
#include <glm/vec3.hpp>
#include <optional>
#include <system_error>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using Kind = PictureData::Kind;

bool isOfStore(const PictureData& data) {
    return data.kind == Kind::volume || data.kind == Kind::labels;
}

std::string lowerExtension(const fs::path& path) {
    std::string text = path.extension().string();
    std::ranges::transform(text, text.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

/// The content of a store; "" for anything else.
std::string contentOfStore(const fs::path& path, MemoryBudget& ram) {
    try {
        return looksLikeStore(path) ? StoreReader(path, ram).contentHash() : std::string();
    } catch (const InputError&) {
        return {}; // a damaged one is not what is looked for
    }
}

/// True if a named path could be such data.
bool couldBe(const fs::path& path, const PictureData& data) {
    const std::string extension = lowerExtension(path);
    const bool isMesh = meansMesh(path), isSky = extension == ".hdr" || extension == ".exr";
    switch (data.kind) {
    case Kind::mesh:
        return isMesh;
    case Kind::environment:
        return isSky;
    case Kind::labelNames:
        return extension == lowerExtension("names" + data.extension);
    default:
        return !isMesh && !isSky;
    }
}

/// "content 0123456789abcdef, 40 x 33 x 24 voxels, int16"
std::string describe(const PictureData& data) {
    std::string text = data.contentHash.empty() ? "unknown content" : "content " + data.contentHash;
    if (data.extentVoxels != glm::ivec3(0))
        text += ", " + formatExtent(data.extentVoxels) + " voxels";
    if (!data.type.empty())
        text += ", " + printable(data.type);
    if (data.bytes > 0)
        text += ", " + std::to_string(data.bytes) + " bytes";
    if (!data.extension.empty() && data.kind != Kind::volume)
        text += ", " + data.extension;
    return text;
}

class Search {
  public:
    Search(const fs::path& figure, const std::vector<SourceChoice>& sources, Scene& scene, MemoryBudget& ram,
           const CommonOptions& common)
        : figure_(figure), sources_(sources), scene_(scene), ram_(ram), common_(common) {
        std::error_code ignored;
        const fs::path folder = figure.has_parent_path() ? figure.parent_path() : fs::path(".");
        for (fs::directory_iterator at(folder, ignored), end; !ignored && at != end; at.increment(ignored))
            beside_.push_back(at->path());
        std::ranges::sort(beside_);
    }

    /// Takes a named path, whatever it holds.
    FoundData take(const PictureData& wanted, const fs::path& named) {
        const fs::path path = reached(named);
        std::error_code ignored;
        if (!isAddress(path) && !fs::exists(path, ignored))
            throw badFile("--data " + named.string(), nameOf(wanted), "nothing there");
        return {wanted, adopt(wanted, path), "--data"};
    }

    /// Looks for the same content beside the picture and in the cache.
    std::optional<FoundData> look(const PictureData& wanted) {
        if (wanted.contentHash.empty())
            return std::nullopt;
        for (const fs::path& path : beside_) {
            checkInterrupted();
            if (isSame(wanted, path))
                return FoundData{wanted, adopt(wanted, path), "beside the picture"};
        }
        if (!isOfStore(wanted))
            return std::nullopt;
        const auto store = cachedContent(wanted.contentHash, common_);
        if (!store)
            return std::nullopt;
        return FoundData{wanted, adopt(wanted, *store), "the cache of imports"};
    }

  private:
    bool isSame(const PictureData& wanted, const fs::path& path) {
        std::error_code ignored;
        if (isOfStore(wanted))
            return fs::is_directory(path, ignored) && contentOfStore(path, ram_) == wanted.contentHash;
        return fs::is_regular_file(path, ignored) && fs::file_size(path, ignored) == wanted.bytes &&
               contentHashOfFile(path) == wanted.contentHash;
    }

    /// Sets the scene's path. Imports source files.
    /// @return the content
    std::string adopt(const PictureData& wanted, const fs::path& path) {
        fs::path& place = pathOf(wanted, scene_);
        place = isAddress(path) ? path : fs::absolute(path);
        if (wanted.kind == Kind::volume) {
            SceneVolume& volume = scene_.volumes[wanted.number];
            volume.source = sources_[wanted.number];
            place = looksLikeStore(place) ? place : storeFor(volume, InputOptions{}, ram_, common_);
            volume.source = {};
            return StoreReader(place, ram_).contentHash();
        }
        if (wanted.kind == Kind::labels) {
            const SceneVolume& volume = scene_.volumes[wanted.number];
            Labels labels = volume.labels;
            const StoreReader scan(volume.path, ram_, volume.transform);
            importLabelsFor(scan.info(), labels, ram_, common_);
            return StoreReader(labels.store, ram_).contentHash();
        }
        return isAddress(path) ? std::string() : contentHashOfFile(path);
    }

    const fs::path figure_;
    const std::vector<SourceChoice>& sources_;
    Scene& scene_;
    MemoryBudget& ram_;
    const CommonOptions& common_;
    std::vector<fs::path> beside_;
};

} // namespace

std::vector<std::string> assignData(const std::vector<PictureData>& wanted,
                                    const std::vector<std::string>& named, MemoryBudget& ram) {
    std::vector<std::string> paths(wanted.size());
    std::vector<std::string> rest;
    for (const std::string& path : named) {
        const std::string content = isAddress(path) ? std::string() : contentOfStore(path, ram);
        std::size_t n = 0;
        while (n < wanted.size() && !(paths[n].empty() && isOfStore(wanted[n]) && !content.empty() &&
                                      wanted[n].contentHash == content))
            ++n;
        if (n < wanted.size())
            paths[n] = path;
        else
            rest.push_back(path);
    }
    for (const std::string& path : rest) {
        std::size_t n = 0;
        while (n < wanted.size() && !(paths[n].empty() && couldBe(path, wanted[n])))
            ++n;
        if (n == wanted.size())
            throw badFile("--data", "a path for each volume, labels, mesh and environment of the picture",
                          "one more, " + printable(path));
        paths[n] = path;
    }
    return paths;
}

std::vector<FoundData> findData(const fs::path& figure, const std::vector<PictureData>& wanted,
                                const std::vector<SourceChoice>& sources,
                                const std::vector<std::string>& paths, Scene& scene, MemoryBudget& ram,
                                const CommonOptions& common) {
    TESSERA_CHECK(paths.size() == wanted.size());
    Search search(figure, sources, scene, ram, common);
    std::vector<FoundData> all;
    for (std::size_t n = 0; n < wanted.size(); ++n) {
        common.progress->stage("looking for " + nameOf(wanted[n]));
        std::optional<FoundData> found =
            paths[n].empty() ? search.look(wanted[n]) : search.take(wanted[n], paths[n]);
        if (!found)
            throw badFile(figure.string(),
                          nameOf(wanted[n]) + " (" + describe(wanted[n]) +
                              ") beside it, in the cache of imports, or named by --data",
                          "none");
        all.push_back(*std::move(found));
    }
    common.progress->end();
    return all;
}

} // namespace tessera
