// viewer/cli/modules/load_module.h: loads modules: parts of the program that are libraries of their own, and
// the tables of their functions. Picture files and importers stand on some sixty foreign libraries, which
// would all be loaded to print a help.
#pragma once

#include <string>

namespace tessera {

/// Loads the module of that name, which stays until the program ends. Its file NAME.so lies beside the
/// program, or where it was installed. Throws Error naming the file where it is missing, does not fit, or
/// lacks a library.
/// @return its table
const void* loadModule(const std::string& name);

/// The tables begin with this: a module of another version has other functions.
struct ModuleHead {
    const char* version;
};

} // namespace tessera
