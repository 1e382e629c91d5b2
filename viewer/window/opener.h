// viewer/window/opener.h: the opener: a browser of folders and recent files. For a folder with several
// volumes it lists them, each with a small picture. Both are drawn over the picture.
#pragma once

#include "viewer/window/folder_listing.h"
#include "viewer/window/picture_view.h" // Area
#include "viewer/window/window_state.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace tessera {

/// A GL context must be current for its lifetime.
class Opener {
  public:
    Opener() = default;
    ~Opener();
    Opener(const Opener&) = delete;
    Opener& operator=(const Opener&) = delete;
    /// While ImGui's frame is open.
    void draw(WindowState& desk, const Area& area);

  private:
    void browser(WindowState& desk, const Area& area);
    void recent(WindowState& desk);
    void entries(WindowState& desk);
    void choices(WindowState& desk, const Area& area);
    struct Texture {
        unsigned name = 0; // 0: none yet
        glm::vec2 size{0};
    };
    /// Of an offer.
    const Texture& textureOf(const WindowState& desk, std::size_t offer);
    void dropTextures();
    void goTo(WindowState& desk, const std::filesystem::path& folder);

    std::optional<FolderListing> listing_;
    std::shared_ptr<const VolumeOffers> of_; // offers of textures_
    std::vector<Texture> textures_;
};

} // namespace tessera
