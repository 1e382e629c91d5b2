// viewer/cli/options/command_table.h: a command with its options and commands as data: what help says of
// them, for pages of the manual and for shells.
#pragma once

#include <string>
#include <vector>

namespace tessera {

struct OptionRow {
    std::vector<std::string> names; ///< {"-o", "--output"}; of a positional argument {"X"}
    std::string about;
    std::string value;   ///< name of its value, "TEXT"; empty for a flag
    std::string initial; ///< value without it; empty where the command shows none
    bool isPositional = false, isRequired = false, mayRepeat = false;
    std::vector<std::string> needs, excludes; ///< other options, "--output"
    std::vector<std::string> offered;         ///< words that its value may be
};

struct CommandRow {
    std::string name, about, footer;
    bool needsCommand = false;
    std::vector<OptionRow> options; ///< as help lists them: positional arguments first
    std::vector<CommandRow> commands;
};

/// The long names of a command's options: "--output".
std::vector<std::string> longNames(const CommandRow& command);

} // namespace tessera
