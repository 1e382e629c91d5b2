// viewer/cli/options/command.h: a command and its options, declared as plain data: names, destinations and
// one sentence each. Only command.cpp and command_table.cpp include the parser.
#pragma once

#include <cstddef>
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

struct CommandRow; // command_table.h

/// A check of an option's value.
/// @return "", or "expected ..., found ..."
using ValueCheck = std::function<std::string(const std::string& text)>;
/// A whole number from `lowest` to the largest int.
ValueCheck wholeNumberFrom(int lowest);
/// A finite number within [lowest, highest].
/// @param what  "voxels from 1/64 to 16"
ValueCheck numberWithin(double lowest, double highest, const std::string& what);

/// A number's text without its unit: "5mm" and "5 mm" are "5". Text without the unit, or the unit alone, is
/// unchanged.
std::string withoutUnit(const std::string& text, const std::string& unit);
/// Finite numbers between commas, each of which may have "mm" behind it; nullopt unless they are `count`.
std::optional<std::vector<double>> lengthsOf(const std::string& text, std::size_t count);

/// A declared option. All functions return it, for chaining.
class Option {
  public:
    explicit Option(CLI::Option& option) : option_(&option) {}
    Option& required();
    Option& check(const ValueCheck& check);
    /// Its number may have a unit: "mm". Checks get the number.
    Option& inUnit(const std::string& unit);
    /// The value's name in help: "FLOAT".
    Option& takes(const std::string& type);
    /// Help shows the target's current value as default.
    Option& showsDefault();
    /// Requires, or excludes, another option ("--output").
    Option& needs(const std::string& other);
    Option& excludes(const std::string& other);
    /// Each value needs its own option: it takes only one.
    Option& oneValueEach();
    /// Words that its value may be, for the completion of shells; others are taken as before.
    Option& offers(const std::vector<std::string>& words);

  private:
    CLI::Option* option_;
};

class Command {
  public:
    explicit Command(CLI::App& app) : app_(&app) {}

    /// @param names  "-o,--output", or "X" for a positional argument
    /// @param target  must outlive the parsing
    Option option(const std::string& names, std::string& target, const std::string& about);
    Option option(const std::string& names, std::vector<std::string>& target, const std::string& about);
    Option option(const std::string& names, int& target, const std::string& about);
    Option option(const std::string& names, double& target, const std::string& about);
    Option option(const std::string& names, std::optional<double>& target, const std::string& about);
    /// @param take  gets the text; called where the option is given
    Option option(const std::string& names, const std::function<void(const std::string&)>& take,
                  const std::string& about);
    Option flag(const std::string& names, bool& target, const std::string& about);

    Command command(const std::string& name, const std::string& about);
    /// A subcommand is required.
    void needsCommand();
    /// The last part of help.
    void footer(const std::string& text);
    /// Called when the command was chosen and parsed.
    void whenChosen(std::function<void()> callback);
    /// What help says of it and of its commands, as data.
    CommandRow table() const;

  private:
    CLI::App* app_;
};

/// A program's commands, and the command line.
class CommandLine {
  public:
    CommandLine(const std::string& name, const std::string& version, const std::string& about);
    ~CommandLine();
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

    /// The program itself; its options may also follow a command.
    Command program() { return Command(*app_); }
    /// @return the exit code if help or the version was printed
    /// Throws InputError for invalid arguments, naming the nearest command or option, and for an option with
    /// an empty value, which would be taken for a missing option.
    std::optional<int> parse(int argc, char** argv);

  private:
    std::unique_ptr<CLI::App> app_;
};

// The likely option for an unknown one: by another program's name, by a part of its name, or by spelling.

/// The known option that an unknown one most likely means; "" if none is near. All with their leading "--";
/// text after "=" is ignored.
std::string likelyOption(const std::string& unknown, const std::vector<std::string>& known);

} // namespace tessera
