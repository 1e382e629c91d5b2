// viewer/cli/render/first_picture.h: a coarse picture that is there long before the picture itself. It
// is made where --first asked for it, and where somebody watches a picture that takes long. The latter goes
// with the command.
#pragma once

#include "viewer/cli/render/render_task.h"

#include <filesystem>
#include <memory>

namespace tessera {

class FirstPicture {
  public:
    /// Decides whether there is one, and where. Throws InputError for --first with an engine that draws none.
    /// task outlives this.
    explicit FirstPicture(const RenderTask& task);
    ~FirstPicture();
    bool wanted() const { return !path_.empty(); }
    /// Writes it, and notes that.
    /// @param secondsLeft  that the picture itself takes from here on, estimated
    void write(const Image& image, double secondsLeft);
    /// From the start of the process until it was written; 0: there was none.
    double seconds() const { return seconds_; }

  private:
    class PassingFile;

    const RenderTask& task_;
    std::filesystem::path path_;           // empty: none is wanted
    std::unique_ptr<PassingFile> passing_; // where nobody asked for it
    double seconds_ = 0;
};

} // namespace tessera
