// viewer/python/call.h: a call of Python that takes long. The work is done by a thread of its own, without
// the interpreter's lock. Meanwhile the caller's thread looks for Ctrl-C and tells how far the work is.
#pragma once

#include "viewer/cli/options/options.h"

#include <functional>
#include <pybind11/pybind11.h>
#include <string>
#include <vector>

namespace tessera::python {

namespace py = pybind11;

class Call {
  public:
    /// Prints nothing: notes and warnings are kept.
    /// @param progress  called with (stage, share) on the caller's thread, share in [0,1]; None: not called
    explicit Call(py::object progress);
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

    /// For the functions of the program.
    const CommonOptions& common() const { return common_; }
    /// Does the work, which must not touch Python. Throws what it throws, and error_already_set where the
    /// progress function or a handler of signals raises; the work is cancelled then, and has ended. Throws
    /// Cancelled where the function returns False.
    void run(const std::function<void()>& work);
    /// Notes and warnings so far.
    const std::vector<std::string>& notes() const { return notes_; }

  private:
    void tell(const std::string& stage, double share);

    py::object progress_;
    CommonOptions common_;
    std::vector<std::string> notes_;
    std::string toldStage_;
    double toldShare_ = -1;
};

/// Adds Error, InputError, OverBudget and Cancelled, and what turns exceptions of C++ into them.
void addErrors(py::module_& module);

} // namespace tessera::python
