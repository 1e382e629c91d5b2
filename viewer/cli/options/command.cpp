// viewer/cli/options/command.cpp: see command.h.
#include "viewer/cli/options/command.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/base/output_file.h" // finishStandardOutput
#include "viewer/cli/options/option_names.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace tessera {
namespace {

std::string refusal(const std::string& expected, const std::string& found) {
    constexpr std::size_t kShown = 40;
    return "expected " + expected + ", found \"" + found.substr(0, kShown) + "\"";
}

void refuseEmptyValues(const CLI::App& program) {
    for (const CLI::Option* option : program.get_options())
        for (const std::string& value : option->results())
            if (value.empty())
                throw badFile(option->get_name(), option->get_description(), "\"" + value + "\"");
    for (const CLI::App* command : program.get_subcommands())
        refuseEmptyValues(*command);
}

std::vector<std::string> commandNames(const CLI::App& program) {
    std::vector<std::string> names;
    for (const CLI::App* command : program.get_subcommands({}))
        names.push_back(command->get_name());
    return names;
}

/// A mistyped command, or one of a command's own, found before the parser, which would only say that one is
/// missing.
void checkCommand(const CLI::App& program, char** from, char** end, const std::string& of = "") {
    const auto isWord = [](const char* argument) { return argument[0] != '-'; };
    char** const word = std::find_if(from, end, isWord);
    if (word == end)
        return;
    const std::vector<std::string> names = commandNames(program);
    if (std::find(names.begin(), names.end(), *word) == names.end())
        throw badFile("command line", "a command" + of + " (" + joinNames(names) + ")",
                      "\"" + std::string(*word) + "\"; nearest: \"" + nearestName(*word, names) + "\"");
    if (const CLI::App& command = *program.get_subcommand(*word); command.get_require_subcommand_min() > 0)
        checkCommand(command, word + 1, end, " of " + command.get_name());
}

/// The parser's complaint, with the nearest option where one was unknown.
std::string explainParseError(const CLI::App& program, const CLI::ParseError& error) {
    std::string message = error.what();
    std::replace(message.begin(), message.end(), '\n', ' ');
    std::vector<std::string> options;
    const auto collect = [&options](const CLI::App& app) {
        for (const CLI::Option* option : app.get_options())
            for (const std::string& longName : option->get_lnames())
                options.push_back("--" + longName);
    };
    collect(program);
    std::string command;
    for (const CLI::App* chosen : program.get_subcommands()) {
        collect(*chosen);
        command = " " + chosen->get_name();
    }
    const std::string more = ": At Most 1 required but received "; // as the parser has it
    if (const std::size_t at = message.find(more); at != std::string::npos)
        message =
            message.substr(0, at) + ": expected once, found " + message.substr(at + more.size()) + " times";
    const std::vector<std::string> extras = program.remaining(true);
    const auto unknown = std::find_if(extras.begin(), extras.end(),
                                      [](const std::string& extra) { return extra.rfind("--", 0) == 0; });
    if (unknown != extras.end()) {
        const std::string likely = likelyOption(*unknown, options);
        message = "unknown option " + *unknown + (likely.empty() ? "" : "; nearest: " + likely);
    }
    return message + " (tessera" + command + " --help shows how)";
}

} // namespace

ValueCheck wholeNumberFrom(int lowest) {
    return [lowest](const std::string& text) {
        int number = 0;
        const char* const end = text.data() + text.size();
        const auto [stopped, error] = std::from_chars(text.data(), end, number);
        return error == std::errc() && stopped == end && number >= lowest
                   ? std::string()
                   : refusal("a whole number from " + std::to_string(lowest), text);
    };
}

ValueCheck numberWithin(double lowest, double highest, const std::string& what) {
    return [lowest, highest, what](const std::string& text) {
        char* end = nullptr;
        const double number = std::strtod(text.c_str(), &end);
        const bool whole = !text.empty() && *end == '\0' && std::isfinite(number);
        return whole && number >= lowest && number <= highest ? std::string() : refusal(what, text);
    };
}

std::string withoutUnit(const std::string& text, const std::string& unit) {
    if (!text.ends_with(unit))
        return text;
    const std::string number = text.substr(0, text.size() - unit.size());
    const std::size_t end = number.find_last_not_of(' ');
    return end == std::string::npos ? text : number.substr(0, end + 1);
}

Option& Option::required() {
    option_->required();
    return *this;
}
Option& Option::check(const ValueCheck& check) {
    option_->check(CLI::Validator([check](std::string& text) { return check(text); }, ""));
    return *this;
}
Option& Option::inUnit(const std::string& unit) {
    option_->transform(CLI::Validator(
        [unit](std::string& text) {
            text = withoutUnit(text, unit);
            return std::string();
        },
        ""));
    return *this;
}
Option& Option::takes(const std::string& type) {
    option_->type_name(type);
    return *this;
}
Option& Option::showsDefault() {
    option_->capture_default_str();
    return *this;
}
Option& Option::needs(const std::string& other) {
    option_->needs(other);
    return *this;
}
Option& Option::excludes(const std::string& other) {
    option_->excludes(other);
    return *this;
}
Option& Option::oneValueEach() {
    option_->allow_extra_args(false);
    return *this;
}

Option Command::option(const std::string& names, std::string& target, const std::string& about) {
    return Option(*app_->add_option(names, target, about));
}
Option Command::option(const std::string& names, std::vector<std::string>& target, const std::string& about) {
    return Option(*app_->add_option(names, target, about));
}
Option Command::option(const std::string& names, int& target, const std::string& about) {
    return Option(*app_->add_option(names, target, about));
}
Option Command::option(const std::string& names, double& target, const std::string& about) {
    return Option(*app_->add_option(names, target, about));
}
Option Command::option(const std::string& names, std::optional<double>& target, const std::string& about) {
    return Option(*app_->add_option(names, target, about));
}
Option Command::flag(const std::string& names, bool& target, const std::string& about) {
    return Option(*app_->add_flag(names, target, about));
}
Command Command::command(const std::string& name, const std::string& about) {
    return Command(*app_->add_subcommand(name, about));
}
void Command::needsCommand() {
    app_->require_subcommand(1);
}
void Command::footer(const std::string& text) {
    app_->footer(text);
}
void Command::whenChosen(std::function<void()> callback) {
    app_->callback(std::move(callback));
}

CommandLine::CommandLine(const std::string& name, const std::string& version, const std::string& about)
    : app_(std::make_unique<CLI::App>(about)) {
    app_->name(name);
    app_->set_version_flag("--version", name + " " + version);
    app_->fallthrough();
    app_->require_subcommand(1);
}
CommandLine::~CommandLine() = default;

std::optional<int> CommandLine::parse(int argc, char** argv) {
    checkCommand(*app_, argv + 1, argv + argc);
    try {
        app_->parse(argc, argv);
    } catch (const CLI::Success& success) { // --help, --version
        const int code = app_->exit(success);
        finishStandardOutput();
        return code;
    } catch (const CLI::ParseError& error) {
        throw InputError(explainParseError(*app_, error));
    }
    refuseEmptyValues(*app_);
    return std::nullopt;
}

} // namespace tessera
