// viewer/cli/pages/manual_pages.h: pages of the manual, as man(1) shows them, from a program's table of
// commands.
#pragma once

#include "viewer/cli/options/command_table.h"

#include <map>
#include <string>

namespace tessera {

/// What the table does not say of a program.
struct ManualHead {
    std::string name;    ///< as text has it, "Tessera"
    std::string version; ///< "0.1.0"
    std::string date;    ///< of the pages, "2026-11-29"; may be empty
};

/// A page for the program and one for each of its commands, in the language of troff (macros of man(7)).
/// @return text by the name of its file, "tessera.1" and "tessera-render.1"
std::map<std::string, std::string> manualPages(const CommandRow& program, const ManualHead& head);

} // namespace tessera
