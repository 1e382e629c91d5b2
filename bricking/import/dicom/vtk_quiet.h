// bricking/import/dicom/vtk_quiet.h: keeps what VTK and vtk-dicom print away from the console: their texts
// may quote header values, and an identifier must not reach a log. What went wrong is said by our own errors.
#pragma once

#include <memory>

namespace tessera {

/// While it lives, messages of VTK are swallowed. Not to be nested.
class QuietVtk {
  public:
    QuietVtk();
    ~QuietVtk();
    QuietVtk(const QuietVtk&) = delete;
    QuietVtk& operator=(const QuietVtk&) = delete;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace tessera
