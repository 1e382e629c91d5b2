// bricking/import/dicom/vtk_quiet.cpp: see vtk_quiet.h.
#include "bricking/import/dicom/vtk_quiet.h"

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
    void DisplayErrorText(const char*) override {}
    void DisplayWarningText(const char*) override {}
    void DisplayGenericWarningText(const char*) override {}
    void DisplayDebugText(const char*) override {}
};
vtkStandardNewMacro(SilentWindow)

} // namespace

struct QuietVtk::State {
    vtkSmartPointer<SilentWindow> silent = vtkSmartPointer<SilentWindow>::New();
    vtkSmartPointer<vtkOutputWindow> before;
};

QuietVtk::QuietVtk() : state_(std::make_unique<State>()) {
    state_->before = vtkOutputWindow::GetInstance();
    vtkOutputWindow::SetInstance(state_->silent);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF); // VTK 9 logs beside the output window
}

QuietVtk::~QuietVtk() {
    vtkOutputWindow::SetInstance(state_->before);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_INFO); // VTK's default; it cannot be asked
}

} // namespace tessera
