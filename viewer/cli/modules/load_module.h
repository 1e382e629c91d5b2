// viewer/cli/modules/load_module.h: loads modules: parts of the program in libraries of their own, with
// tables of their functions. Picture files and importers need some sixty foreign libraries, which would
// otherwise be loaded even for --help.
#pragma once

#include <string>

namespace tessera {

/// Loads the module of that name, which stays until the program ends. Its file NAME.so is beside the program,
/// or beside the library that holds this function (Python's module), or in the installation. Throws Error
/// naming the file if it is missing, has another version, or lacks a library.
/// @return its table
const void* loadModule(const std::string& name);

/// First member of all tables: rejects modules of another version.
struct ModuleHead {
    const char* version;
};

} // namespace tessera
