// bricking/import/dicom/vtk_quiet.h: keeps messages of VTK and vtk-dicom off the console. Their texts may
// quote header values, and an identifier must not reach a log. Our own errors say what went wrong.
#pragma once

#include <memory>

namespace tessera {

/// While it lives, messages of VTK are suppressed. Not to be nested.
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
