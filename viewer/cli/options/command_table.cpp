// viewer/cli/options/command_table.cpp: see command_table.h.
#include "viewer/cli/options/command_table.h"

#include "viewer/cli/options/command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace tessera {
namespace {

// The parser keeps no words of a value: a check without effect keeps them in its name.
constexpr const char* kOffers = "offers";

std::vector<std::string> offeredBy(const CLI::Option& option) {
    std::vector<std::string> words;
    try {
        for (int i = 0;; ++i) { // until there is none
            std::istringstream name(const_cast<CLI::Option&>(option).get_validator(i)->get_name());
            std::string word;
            if (!(name >> word) || word != kOffers)
                continue;
            while (name >> word)
                words.push_back(word);
        }
    } catch (const CLI::OptionNotFound&) {
        return words;
    }
}

std::vector<std::string> optionNames(const std::set<CLI::Option*>& options) {
    std::vector<std::string> names;
    for (const CLI::Option* option : options)
        names.push_back(option->get_name());
    std::sort(names.begin(), names.end()); // the set is in the order of addresses
    return names;
}

OptionRow rowOf(const CLI::Option& option) {
    OptionRow row;
    row.isPositional = option.get_positional();
    if (row.isPositional)
        row.names.push_back(option.get_name());
    for (const std::string& name : option.get_snames())
        row.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames())
        row.names.push_back("--" + name);
    row.about = option.get_description();
    if (option.get_items_expected_max() > 0)
        row.value = option.get_type_name();
    row.initial = option.get_default_str();
    row.isRequired = option.get_required();
    row.mayRepeat = option.get_expected_max() > 1;
    row.needs = optionNames(option.get_needs());
    row.excludes = optionNames(option.get_excludes());
    row.offered = offeredBy(option);
    return row;
}

CommandRow rowOf(const CLI::App& app) {
    CommandRow row{app.get_name(),
                   app.get_description(),
                   app.get_footer(),
                   app.get_require_subcommand_min() > 0,
                   {},
                   {}};
    for (const CLI::Option* option : app.get_options())
        row.options.push_back(rowOf(*option));
    std::stable_partition(row.options.begin(), row.options.end(),
                          [](const OptionRow& option) { return option.isPositional; });
    for (const CLI::App* command : app.get_subcommands({}))
        row.commands.push_back(rowOf(*command));
    return row;
}

} // namespace

Option& Option::offers(const std::vector<std::string>& words) {
    std::string name = kOffers;
    for (const std::string& word : words)
        name += " " + word;
    option_->check(CLI::Validator([](std::string&) { return std::string(); }, "", name));
    return *this;
}

std::vector<std::string> longNames(const CommandRow& command) {
    std::vector<std::string> names;
    for (const OptionRow& option : command.options)
        for (const std::string& name : option.names)
            if (name.starts_with("--"))
                names.push_back(name);
    return names;
}

CommandRow Command::table() const {
    return rowOf(*app_);
}

} // namespace tessera
