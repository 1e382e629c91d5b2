// bricking/import/vtk_quiet.h: keeps what VTK, vtk-dicom and GDCM print away from the console: their texts
// may quote header values, and an identifier must not reach a log. What went wrong is said by our own errors.
#pragma once

#include <memory>

namespace tessera {

/// While it lives, messages of VTK are swallowed and noted; with decoderToo also what GDCM writes to
/// std::cerr (the stream of the whole process, so kept to single decode calls). Not to be nested.
class QuietVtk {
  public:
    explicit QuietVtk(bool decoderToo = false);
    ~QuietVtk();
    QuietVtk(const QuietVtk&) = delete;
    QuietVtk& operator=(const QuietVtk&) = delete;

    /// True if VTK reported an error (not a mere warning) since construction.
    bool sawError() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace tessera
