// viewer/python/call.cpp: see call.h.
#include "viewer/python/call.h"

#include "core/base/budget_error.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <exception>
#include <memory>
#include <mutex>
#include <pthread.h>
#include <thread>
#include <utility>

namespace tessera::python {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks{50}; // for Ctrl-C and progress

/// While it lives, new threads get no signals: Python's handlers would interrupt what they read and write.
class SignalsBlocked {
  public:
    SignalsBlocked() {
        sigset_t all;
        ::sigfillset(&all);
        for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT})
            ::sigdelset(&all, fault);
        ::pthread_sigmask(SIG_BLOCK, &all, &before_);
    }
    ~SignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsBlocked(const SignalsBlocked&) = delete;
    SignalsBlocked& operator=(const SignalsBlocked&) = delete;

  private:
    sigset_t before_{};
};

/// Work on a thread of its own; those that it starts get no signals either.
class CallThread {
  public:
    explicit CallThread(const std::function<void()>& work) {
        const SignalsBlocked blocked;
        thread_ = std::thread([this, &work] { run(work); });
    }
    ~CallThread() { thread_.join(); }
    CallThread(const CallThread&) = delete;
    CallThread& operator=(const CallThread&) = delete;

    void cancel() { cancelled_ = true; }
    /// @return true if the work has ended
    bool waitFor(std::chrono::milliseconds time) {
        std::unique_lock lock(mutex_);
        return ended_.wait_for(lock, time, [this] { return isDone_; });
    }
    /// Once it has ended.
    void rethrow() const {
        if (failure_)
            std::rethrow_exception(failure_);
    }

  private:
    void run(const std::function<void()>& work) {
        const Cancellation cancellation(&cancelled_);
        try {
            work();
        } catch (...) {
            failure_ = std::current_exception();
        }
        const std::lock_guard lock(mutex_);
        isDone_ = true;
        ended_.notify_one();
    }

    Cancellation::Flag cancelled_{false};
    std::mutex mutex_;
    std::condition_variable ended_;
    bool isDone_ = false;
    std::exception_ptr failure_;
    std::thread thread_;
};

} // namespace

Call::Call(py::object progress) : progress_(std::move(progress)) {
    if (!progress_.is_none() && PyCallable_Check(progress_.ptr()) == 0)
        throw InputError("progress: expected a function of a stage and a share, found " +
                         std::string(Py_TYPE(progress_.ptr())->tp_name));
    common_.quiet = true;
    common_.progress = std::make_shared<Progress>(Verbosity::quiet, true);
    common_.listener = [this](const std::string& line) { notes_.push_back(line); };
}

void Call::tell(const std::string& stage, double share) {
    if (progress_.is_none() || stage.empty() || (stage == toldStage_ && share == toldShare_))
        return;
    toldStage_ = stage;
    toldShare_ = share;
    if (progress_(stage, share).is(py::bool_(false)))
        throw Cancelled();
}

void Call::run(const std::function<void()>& work) {
    std::exception_ptr stop; // raised by Python
    {
        CallThread worker(work);
        for (bool ended = false; !ended;) {
            {
                const py::gil_scoped_release released;
                ended = worker.waitFor(stop ? std::chrono::hours(1) : kBetweenLooks);
            }
            if (ended || stop)
                continue;
            try {
                if (PyErr_CheckSignals() != 0)
                    throw py::error_already_set();
                const Progress::Stage now = common_.progress->now();
                tell(now.what, now.share);
            } catch (...) {
                stop = std::current_exception();
                worker.cancel();
            }
        }
        if (!stop)
            worker.rethrow();
    }
    if (stop)
        std::rethrow_exception(stop);
    tell(common_.progress->now().what, 1);
}

void addErrors(py::module_& module) {
    // They live as long as the process: translators outlive the module.
    static PyObject *error = nullptr, *inputError = nullptr, *overBudget = nullptr, *cancelled = nullptr;
    const auto add = [&module](const char* name, const char* about, const py::tuple& bases) {
        const std::string whole = std::string("tessera.") + name;
        PyObject* const made = PyErr_NewExceptionWithDoc(whole.c_str(), about, bases.ptr(), nullptr);
        if (!made)
            throw py::error_already_set();
        module.attr(name) = py::reinterpret_borrow<py::object>(made);
        return made;
    };
    const auto of = [](PyObject* type) { return py::reinterpret_borrow<py::object>(type); };
    error = add("Error", "Something outside the program failed: a driver, a disk.",
                py::make_tuple(of(PyExc_RuntimeError)));
    inputError = add("InputError", "Bad use or bad input: what was expected, and what was found.",
                     py::make_tuple(of(error), of(PyExc_ValueError)));
    overBudget =
        add("OverBudget", "A budget of memory is too small: the message names the argument that raises it.",
            py::make_tuple(of(inputError), of(PyExc_MemoryError)));
    cancelled = add("Cancelled", "The progress function returned False.", py::make_tuple(of(error)));
    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown)
                std::rethrow_exception(thrown);
        } catch (const OverBudget& e) {
            PyErr_SetString(overBudget, e.what());
        } catch (const InputError& e) {
            PyErr_SetString(inputError, e.what());
        } catch (const Error& e) {
            PyErr_SetString(error, e.what());
        } catch (const Cancelled& e) {
            PyErr_SetString(cancelled, e.what());
        } catch (const Interrupted&) {
            PyErr_SetNone(PyExc_KeyboardInterrupt);
        }
    });
}

} // namespace tessera::python
