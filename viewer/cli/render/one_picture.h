// viewer/cli/render/one_picture.h: `tessera render` without --path: one converged picture and its manifest.
#pragma once

#include "viewer/cli/render/render_task.h"

#include <filesystem>
#include <memory>

namespace tessera {

// A coarse picture before the picture itself. It is made for --first, and on a terminal for pictures that
// take long. The latter is removed when the command ends.

class FirstPicture {
  public:
    /// Decides whether to make one, and its path. Throws InputError for --first with an engine that draws
    /// none. task outlives this.
    explicit FirstPicture(const RenderTask& task);
    ~FirstPicture();
    bool wanted() const { return !path_.empty(); }
    /// Writes it, with a note.
    /// @param secondsLeft  estimated time for the picture itself; 0: not known
    void write(const Image& image, double secondsLeft);
    /// Time from the start of the process until it was written; 0: there was none.
    double seconds() const { return seconds_; }

  private:
    class PassingFile;

    const RenderTask& task_;
    std::filesystem::path path_;           // empty: none
    std::unique_ptr<PassingFile> passing_; // without --first
    double seconds_ = 0;
};

/// Draws and writes it. Throws as renderScene() and writeImage() do, and InputError for --first with an
/// engine that draws none.
void renderOnePicture(const RenderTask& task);

} // namespace tessera
