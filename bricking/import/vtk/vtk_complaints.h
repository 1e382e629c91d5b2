// bricking/import/vtk/vtk_complaints.h: what VTK's readers complain about. They go on after that with what
// they have, so a complaint is damage.
#pragma once

#include <cctype>
#include <initializer_list>
#include <mutex>
#include <string>
#include <vtkAlgorithm.h>
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkExecutive.h>
#include <vtkLogger.h>
#include <vtkNew.h>

namespace tessera {

class VtkComplaints {
  public:
    /// Of a reader and of what executes it; both live as long as this.
    explicit VtkComplaints(vtkAlgorithm& reader) {
        command_->SetClientData(this);
        command_->SetCallback([](vtkObject*, unsigned long, void* self, void* text) {
            auto& first = static_cast<VtkComplaints*>(self)->first_;
            if (first.empty())
                first = text ? static_cast<const char*>(text) : "damage";
        });
        for (vtkObject* const source :
             {static_cast<vtkObject*>(&reader), static_cast<vtkObject*>(reader.GetExecutive())}) {
            source->AddObserver(vtkCommand::ErrorEvent, command_); // what is observed is not printed
            source->AddObserver(vtkCommand::WarningEvent, command_);
        }
    }
    VtkComplaints(const VtkComplaints&) = delete;
    VtkComplaints& operator=(const VtkComplaints&) = delete;

    /// For objects that a reader makes itself.
    vtkCommand* observer() { return command_; }
    /// The first one's last line; empty: there was none.
    std::string first() const {
        std::string text = first_;
        while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())))
            text.pop_back();
        return text.substr(text.rfind('\n') + 1);
    }

  private:
    vtkNew<vtkCallbackCommand> command_;
    std::string first_;
};

/// While it lives VTK prints nothing: not what objects say that a reader makes, whom nobody observes.
class VtkSilence {
  public:
    VtkSilence() {
        const std::lock_guard lock(mutex_);
        if (silences_++ == 0)
            vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
    }
    ~VtkSilence() {
        const std::lock_guard lock(mutex_);
        if (--silences_ == 0)
            vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_INFO); // as it is at first
    }
    VtkSilence(const VtkSilence&) = delete;
    VtkSilence& operator=(const VtkSilence&) = delete;

  private:
    inline static std::mutex mutex_;
    inline static int silences_ = 0;
};

} // namespace tessera
