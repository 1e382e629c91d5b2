// viewer/session/finer_import.cpp: see finer_import.h.
#include "viewer/session/finer_import.h"

#include "core/base/error.h"

#include <exception>
#include <utility>

namespace tessera {

FinerImport::FinerImport(const std::filesystem::path& path, const InputOptions& input, MemoryBudget& ram,
                         std::function<void()> ended) {
    common_.quiet = true;
    result_ = std::async(std::launch::async, [this, path, input, &ram, ended = std::move(ended)] {
        const Cancellation asks(&calledOff_);
        std::string problem;
        try {
            storeFor(path, input, ram, common_);
        } catch (const std::exception& e) {
            problem = e.what();
        }
        ended();
        return problem;
    });
}

FinerImport::~FinerImport() {
    calledOff_ = true;
    if (result_.valid())
        result_.wait();
}

} // namespace tessera
