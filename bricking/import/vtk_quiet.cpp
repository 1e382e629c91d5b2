// bricking/import/vtk_quiet.cpp: see vtk_quiet.h.
#include "bricking/import/vtk_quiet.h"

#include <iostream>
#include <sstream>
#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

namespace tessera {
namespace {

class SilentWindow final : public vtkOutputWindow {
  public:
    static SilentWindow* New();
    vtkTypeMacro(SilentWindow, vtkOutputWindow) void DisplayText(const char*) override {}
    void DisplayErrorText(const char*) override { sawError = true; }
    void DisplayWarningText(const char*) override {}
    void DisplayGenericWarningText(const char*) override {}
    void DisplayDebugText(const char*) override {}
    bool sawError = false;
};
vtkStandardNewMacro(SilentWindow)

} // namespace

struct QuietVtk::State {
    vtkSmartPointer<SilentWindow> silent = vtkSmartPointer<SilentWindow>::New();
    vtkSmartPointer<vtkOutputWindow> before;
    std::ostringstream swallowed;
    std::streambuf* cerrBefore = nullptr;
};

QuietVtk::QuietVtk(bool decoderToo) : state_(std::make_unique<State>()) {
    state_->before = vtkOutputWindow::GetInstance();
    vtkOutputWindow::SetInstance(state_->silent);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF); // VTK 9 logs beside the output window
    if (decoderToo)
        state_->cerrBefore = std::cerr.rdbuf(state_->swallowed.rdbuf());
}

QuietVtk::~QuietVtk() {
    if (state_->cerrBefore)
        std::cerr.rdbuf(state_->cerrBefore);
    vtkOutputWindow::SetInstance(state_->before);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_INFO); // VTK's default; it cannot be asked
}

bool QuietVtk::sawError() const {
    return state_->silent->sawError;
}

} // namespace tessera
