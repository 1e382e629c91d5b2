// viewer/cli/pages/shell_completion.cpp: see shell_completion.h. Both scripts know, for every command, its
// options, those that take a value, and the words that a value may be; any other word is the name of a file.
#include "viewer/cli/pages/shell_completion.h"

#include "core/base/error.h"
#include "core/base/names.h"

#include <functional>
#include <string>
#include <vector>

namespace tessera {
namespace {

std::string wordList(const std::vector<std::string>& words, const std::string& between = " ") {
    std::string out;
    for (const std::string& word : words)
        out += (out.empty() ? "" : between) + word;
    return out;
}

bool takesValue(const OptionRow& option) {
    return !option.isPositional && !option.value.empty();
}

/// Words that are neither options nor their values: commands of the command, and what its arguments may be.
std::vector<std::string> bareWords(const CommandRow& command) {
    std::vector<std::string> words;
    for (const CommandRow& nested : command.commands)
        words.push_back(nested.name);
    for (const OptionRow& option : command.options)
        if (option.isPositional)
            words.insert(words.end(), option.offered.begin(), option.offered.end());
    return words;
}

/// The command's options and those of commands around it, which also hold. `--version` is the program's
/// alone.
std::vector<OptionRow> optionsOf(const CommandRow& command, const std::vector<OptionRow>& around) {
    std::vector<OptionRow> options;
    for (const OptionRow& option : command.options)
        if (!option.isPositional)
            options.push_back(option);
    for (const OptionRow& option : around)
        if (option.names != std::vector<std::string>{"--version"} &&
            option.names != options.front().names) // --help
            options.push_back(option);
    return options;
}

/// Calls for a command and all below it.
/// @param path  the words of the command line that choose it, without the program's
void walk(
    const CommandRow& command, const std::string& path, const std::vector<OptionRow>& around,
    const std::function<void(const CommandRow&, const std::string&, const std::vector<OptionRow>&)>& visit) {
    const std::vector<OptionRow> options = optionsOf(command, around);
    visit(command, path, options);
    for (const CommandRow& nested : command.commands)
        walk(nested, path + " " + nested.name, options, visit);
}

/// Names of an option at a place: "' render -o'|' render --output'"
std::string bashPattern(const std::string& path, const OptionRow& option) {
    std::vector<std::string> patterns;
    for (const std::string& name : option.names)
        patterns.push_back("'" + path + " " + name + "'");
    return wordList(patterns, "|");
}

std::string bashScript(const CommandRow& program) {
    const std::string function = "_" + program.name;
    std::string places, words, choices, files;
    walk(program, "", program.options,
         [&](const CommandRow& command, const std::string& path, const std::vector<OptionRow>& options) {
             std::vector<std::string> names;
             for (const OptionRow& option : options) {
                 names.insert(names.end(), option.names.begin(), option.names.end());
                 if (takesValue(option))
                     (option.offered.empty() ? files : choices) +=
                         "    " + bashPattern(path, option) +
                         (option.offered.empty() ? ") return ;;\n"
                                                 : ") words='" + wordList(option.offered) + "' ;;\n");
             }
             if (!path.empty())
                 places += (places.empty() ? "" : "|") + ("'" + path + "'");
             words += "        '" + path + "') options='" + wordList(names) + "' bare='" +
                      wordList(bareWords(command)) + "' ;;\n";
         });
    return "# Completion of " + program.name + " for bash; written by `" + program.name +
           " completion bash`.\n" + function +
           "() {\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}\n"
           "    local place='' words='' options='' bare='' i\n"
           "    COMPREPLY=()\n"
           "    for ((i = 1; i < COMP_CWORD; i++)); do\n"
           "        case \"$place ${COMP_WORDS[i]}\" in\n"
           "        " +
           places +
           ") place+=\" ${COMP_WORDS[i]}\" ;;\n"
           "        esac\n"
           "    done\n"
           "    case \"$place $before\" in\n" +
           choices + files +
           "    *)\n"
           "        case $place in\n" +
           words +
           "        esac\n"
           "        if [[ $word == -* ]]; then words=$options; else words=$bare; fi\n"
           "        ;;\n"
           "    esac\n"
           "    # What is none of them is the name of a file (complete -o default).\n"
           "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
           "}\n"
           "complete -o default -F " +
           function + " " + program.name + "\n";
}

/// Text within '...' of zsh, and within [...] or :...: of _arguments.
std::string zshText(const std::string& text, const std::string& special) {
    std::string out;
    for (const char c : text)
        if (c == '\'')
            out += "'\\''";
        else
            out += special.find(c) == std::string::npos ? std::string(1, c) : std::string("\\") + c;
    return out;
}

/// What _arguments takes for an option, a line for each of its names.
std::string zshOption(const OptionRow& option) {
    std::string out;
    for (const std::string& name : option.names) {
        out += "        '" + std::string(option.mayRepeat ? "*" : "") + name + "[" +
               zshText(option.about, "[]\\") + "]";
        if (takesValue(option))
            out += ":" + option.value + ":" +
                   (option.offered.empty() ? "_files" : "(" + wordList(option.offered) + ")");
        out += "' \\\n";
    }
    return out;
}

/// The same for arguments that have words.
std::string zshArguments(const CommandRow& command) {
    std::string out;
    int place = 0;
    for (const OptionRow& option : command.options)
        if (option.isPositional && (++place, !option.offered.empty()))
            out += "        '" + std::to_string(place) + ":" + option.names.front() + ":(" +
                   wordList(option.offered) + ")' \\\n";
    return out;
}

std::string zshFunction(const std::string& program, const std::string& path) {
    std::string name = "_" + program + path;
    for (char& c : name)
        c = c == ' ' ? '_' : c;
    return name;
}

std::string zshScript(const CommandRow& program) {
    std::string functions;
    walk(program, "", program.options,
         [&](const CommandRow& command, const std::string& path, const std::vector<OptionRow>& options) {
             const std::string name = zshFunction(program.name, path);
             functions += name + "() {\n    local context state state_descr line\n    typeset -A opt_args\n"
                                 "    _arguments -C \\\n";
             for (const OptionRow& option : options)
                 functions += zshOption(option);
             if (command.commands.empty()) {
                 functions += zshArguments(command) + "        '*:file:_files'\n}\n";
                 return;
             }
             functions += "        '1: :->command' '*:: :->arguments'\n    case $state in\n    command)\n"
                          "        local -a commands=(\n";
             for (const CommandRow& nested : command.commands)
                 functions += "            '" + nested.name + ":" + zshText(nested.about, ":\\") + "'\n";
             functions += "        )\n        _describe command commands\n        ;;\n    arguments)\n"
                          "        case $line[1] in\n";
             for (const CommandRow& nested : command.commands)
                 functions += "        " + nested.name + ") " +
                              zshFunction(program.name, path + " " + nested.name) + " ;;\n";
             functions += "        esac\n        ;;\n    esac\n}\n";
         });
    const std::string function = zshFunction(program.name, "");
    return "#compdef " + program.name + "\n# Completion of " + program.name + " for zsh; written by `" +
           program.name + " completion zsh`.\n" + functions + "if [[ $funcstack[1] == " + function +
           " ]]; then\n    " + function + " \"$@\"\nelse\n    compdef " + function + " " + program.name +
           "\nfi\n";
}

} // namespace

const std::vector<std::string>& completedShells() {
    static const std::vector<std::string> shells = {"bash", "zsh"};
    return shells;
}

std::string shellCompletion(const CommandRow& program, const std::string& shell) {
    if (shell == "bash")
        return bashScript(program);
    if (shell == "zsh")
        return zshScript(program);
    throw badFile("SHELL", joinNames(completedShells()), "\"" + shell + "\"");
}

} // namespace tessera
