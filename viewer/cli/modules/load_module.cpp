// viewer/cli/modules/load_module.cpp: see load_module.h.
#include "viewer/cli/modules/load_module.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <dlfcn.h>
#include <filesystem>

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Of the program itself, wherever it was copied and however it was called.
fs::path programFolder() {
    std::error_code ignored;
    return fs::read_symlink("/proc/self/exe", ignored).parent_path();
}

/// Beside the program, as it is built; else where it is installed.
fs::path fileOf(const std::string& name) {
    const fs::path beside = programFolder() / (name + ".so");
    const fs::path installed = programFolder() / TESSERA_MODULES_FROM_PROGRAM / (name + ".so");
    std::error_code ignored;
    return !fs::exists(beside, ignored) && fs::exists(installed, ignored) ? installed : beside;
}

} // namespace

const void* loadModule(const std::string& name) {
    const fs::path file = fileOf(name);
    const auto refuse = [&file](const std::string& found) -> Error {
        return Error(printable(file.string()) + ": expected a module of tessera " TESSERA_VERSION ", found " +
                     printable(found));
    };
    std::error_code ignored;
    if (!fs::exists(file, ignored))
        throw refuse("nothing there");
    // Lazy: of the libraries that it brings most functions are never called. Its own are bound at once (-z
    // now).
    void* const library = ::dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL | RTLD_NODELETE);
    if (!library)
        throw refuse("one that cannot be loaded: " + std::string(::dlerror()));
    const void* const table = ::dlsym(library, "tesseraModule");
    if (!table)
        throw refuse("another library");
    const std::string version = static_cast<const ModuleHead*>(table)->version;
    if (version != TESSERA_VERSION)
        throw refuse("version " + version);
    return table;
}

} // namespace tessera
