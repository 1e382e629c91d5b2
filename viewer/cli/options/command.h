// viewer/cli/options/command.h: a command and its options, declared as plain data: names, destinations and
// one sentence each. Only command.cpp knows the parser.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace tessera {

/// Refuses an option's value before any work.
/// @return "", or "expected ..., found ..."
using ValueCheck = std::function<std::string(const std::string& text)>;
/// A whole number from `lowest` on that an int holds.
ValueCheck wholeNumberFrom(int lowest);
/// A finite number within [lowest, highest].
/// @param what  "voxels from 1/64 to 16"
ValueCheck numberWithin(double lowest, double highest, const std::string& what);

/// What is left of a number's text without the unit that it is in: "5mm" and "5 mm" are "5". One without, or
/// nothing but the unit, stays as it is.
std::string withoutUnit(const std::string& text, const std::string& unit);

/// An option that was declared. All of these return it, so that they follow one another.
class Option {
  public:
    explicit Option(CLI::Option& option) : option_(&option) {}
    Option& required();
    Option& check(const ValueCheck& check);
    /// Its number may have its unit behind it: "mm". Checks see the number.
    Option& inUnit(const std::string& unit);
    /// Help says that it takes this: "FLOAT".
    Option& takes(const std::string& type);
    /// Help shows what its target holds now.
    Option& showsDefault();
    /// Not without, and not together with, another one ("--output").
    Option& needs(const std::string& other);
    Option& excludes(const std::string& other);
    /// Each value wants its own option: what follows the first is no value of it.
    Option& oneValueEach();

  private:
    CLI::Option* option_;
};

class Command {
  public:
    explicit Command(CLI::App& app) : app_(&app) {}

    /// @param names  "-o,--output", or "X" for what has no dash
    /// @param target  must outlive the parsing
    Option option(const std::string& names, std::string& target, const std::string& about);
    Option option(const std::string& names, std::vector<std::string>& target, const std::string& about);
    Option option(const std::string& names, int& target, const std::string& about);
    Option option(const std::string& names, double& target, const std::string& about);
    Option option(const std::string& names, std::optional<double>& target, const std::string& about);
    Option flag(const std::string& names, bool& target, const std::string& about);

    Command command(const std::string& name, const std::string& about);
    /// One of its commands has to be named.
    void needsCommand();
    /// What help ends with.
    void footer(const std::string& text);
    /// Called when it was chosen and parsed.
    void whenChosen(std::function<void()> callback);

  private:
    CLI::App* app_;
};

/// A program's commands, and what was typed.
class CommandLine {
  public:
    CommandLine(const std::string& name, const std::string& version, const std::string& about);
    ~CommandLine();
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

    /// Of the program itself: its options may stand behind a command too.
    Command program() { return Command(*app_); }
    /// @return the exit code where help or the version was asked for, and is printed Throws InputError for
    /// what cannot be parsed, naming the nearest command or option, and for an option with an empty value.
    /// Such a value means nothing, and would be taken for one that was not given.
    std::optional<int> parse(int argc, char** argv);

  private:
    std::unique_ptr<CLI::App> app_;
};

} // namespace tessera
