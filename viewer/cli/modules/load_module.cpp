// viewer/cli/modules/load_module.cpp: see load_module.h.
#include "viewer/cli/modules/load_module.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <array>
#include <dlfcn.h>
#include <filesystem>
#include <link.h> // link_map
#include <mutex>

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// The library that holds this function, such as Python's module; empty: the program itself does.
std::string ownLibrary() {
    Dl_info info{};
    link_map* map = nullptr;
    const bool known = ::dladdr1(reinterpret_cast<const void*>(&loadModule), &info,
                                 reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) != 0;
    return known && map ? map->l_name : "";
}

/// Of the program itself, wherever it was copied and however it was called.
fs::path programFolder() {
    std::error_code ignored;
    return fs::read_symlink("/proc/self/exe", ignored).parent_path();
}

/// Beside the program or the library, as they are built; else where modules are installed.
fs::path fileOf(const std::string& name, const fs::path& library) {
    const fs::path folder = library.empty() ? programFolder() : library.parent_path();
    const fs::path beside = folder / (name + ".so");
    std::error_code ignored;
    if (fs::exists(beside, ignored))
        return beside;
    for (const char* place : library.empty() ? std::array{TESSERA_MODULES_FROM_PROGRAM, ""}
                                             : std::array{TESSERA_MODULES_FROM_PYTHON, "../.."})
        if (const fs::path other = folder / place / (name + ".so"); fs::exists(other, ignored))
            return other;
    return beside;
}

/// Modules find what they need in the program, whose symbols all libraries see. Those of a library they see
/// once it is opened so.
void showOwnSymbols(const std::string& library) {
    static std::once_flag once;
    std::call_once(once, [&] { ::dlopen(library.c_str(), RTLD_LAZY | RTLD_GLOBAL | RTLD_NOLOAD); });
}

} // namespace

const void* loadModule(const std::string& name) {
    const std::string holder = ownLibrary();
    if (!holder.empty())
        showOwnSymbols(holder);
    const fs::path file = fileOf(name, holder);
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
