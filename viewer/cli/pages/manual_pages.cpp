// viewer/cli/pages/manual_pages.cpp: see manual_pages.h.
#include "viewer/cli/pages/manual_pages.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string>
#include <vector>

namespace tessera {
namespace {

/// Text of a line as troff shows it unchanged. Hyphens before options are those that one can copy.
std::string shown(const std::string& text) {
    std::string out;
    char before = ' ';
    for (const char c : text) {
        const bool startsWord = std::isalnum(static_cast<unsigned char>(before)) == 0;
        switch (c) {
        case '\\':
            out += "\\e";
            break;
        case '-':
            out += startsWord ? "\\-" : "-";
            break;
        case '`':
            out += "\\(ga";
            break;
        case '^':
            out += "\\(ha";
            break;
        case '~':
            out += "\\(ti";
            break;
        default:
            out += c;
        }
        before = c;
    }
    return out;
}

/// The same for what is typed: every hyphen and quote is the typed one.
std::string typed(const std::string& text) {
    std::string out;
    for (const char c : text)
        if (c == '-')
            out += "\\-";
        else if (c == '\'')
            out += "\\(aq";
        else
            out +=
                c == '\\' || c == '`' || c == '^' || c == '~' ? shown(std::string(1, c)) : std::string(1, c);
    return out;
}

/// A line of text, which never begins as a request does.
std::string line(const std::string& text) {
    return (text.starts_with('.') || text.starts_with('\'') ? "\\&" : "") + text + "\n";
}

/// Help's words as they are, because the first may be a value, with a full stop.
std::string sentence(const std::string& text) {
    return text.empty() || text.ends_with('.') ? text : text + ".";
}

std::string bold(const std::string& text) {
    return "\\fB" + typed(text) + "\\fR";
}
std::string slanted(const std::string& text) {
    return "\\fI" + typed(text) + "\\fR";
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
    std::string out;
    for (const std::string& word : words)
        out += (out.empty() ? "" : between) + word;
    return out;
}

/// "-o, --output TEXT" and what it means.
std::string optionItem(const OptionRow& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.names)
        names.push_back(option.isPositional ? slanted(name) : bold(name));
    const bool takesValue = !option.isPositional && !option.value.empty();
    std::string out = ".TP\n" + line(joined(names, ", ") + (takesValue ? " " + slanted(option.value) : ""));
    out += line(shown(sentence(option.about)));
    if (!option.initial.empty())
        out += line("Default: " + typed(option.initial) + ".");
    if (option.isRequired && !option.isPositional)
        out += line("Required.");
    if (!option.needs.empty())
        out += line("Only with " + typed(joined(option.needs, ", ")) + ".");
    if (!option.excludes.empty())
        out += line("Not with " + typed(joined(option.excludes, ", ")) + ".");
    return out;
}

std::string optionItems(const CommandRow& command, bool positional) {
    std::string out;
    for (const OptionRow& option : command.options)
        if (option.isPositional == positional)
            out += optionItem(option);
    return out;
}

std::string section(const std::string& name, const std::string& text) {
    return text.empty() ? text : ".SH " + name + "\n" + text;
}

/// "tessera render [OPTIONS] X"
std::string synopsis(const std::string& name, const CommandRow& command) {
    std::string text = bold(name) + " [" + slanted("OPTIONS") + "]";
    if (!command.commands.empty())
        text += " " + slanted("COMMAND");
    for (const OptionRow& option : command.options)
        if (option.isPositional) {
            const std::string value = slanted(option.names.front()) + (option.mayRepeat ? " ..." : "");
            text += " " + (option.isRequired ? value : "[" + value + "]");
        }
    return line(text);
}

/// The end of a command's help: sentences, then the lines below "Example:".
struct Footer {
    std::string sentences, example;
};
Footer footerOf(const std::string& text) {
    Footer footer;
    std::istringstream lines(text);
    bool isExample = false;
    for (std::string l; std::getline(lines, l);)
        if (l == "Example:")
            isExample = true;
        else if (isExample)
            footer.example += line(typed(l.substr(std::min(l.size(), l.find_first_not_of(' ')))));
        else if (!l.empty())
            footer.sentences += line(shown(l));
    if (!footer.example.empty())
        footer.example = ".nf\n" + footer.example + ".fi\n";
    return footer;
}

/// Commands of a command, with their options.
std::string nestedCommands(const std::string& name, const CommandRow& command) {
    std::string out;
    for (const CommandRow& nested : command.commands) {
        const std::string whole = name + " " + nested.name;
        out += ".SS " + typed(whole) + "\n" + synopsis(whole, nested) + ".PP\n" +
               line(shown(sentence(nested.about)));
        out += optionItems(nested, true) + optionItems(nested, false);
    }
    return out;
}

constexpr const char* kExitStatus =
    ".TP\n0\nSuccess.\n"
    ".TP\n2\nBad use or bad input.\n"
    ".TP\n130\nInterrupted by Ctrl-C; 128 and its number after another signal.\n"
    ".TP\n1\nAnything else.\n";

std::string pageOf(const std::string& command) {
    std::string page = command;
    std::replace(page.begin(), page.end(), ' ', '-');
    return page;
}

/// @param name  as it is called: "tessera render"
/// @param described  commands or other pages
std::string manualPage(const std::string& name, const CommandRow& command, const ManualHead& head,
                       const std::string& described, const std::string& seeAlso) {
    const Footer footer = footerOf(command.footer);
    std::string title = pageOf(name);
    std::transform(title.begin(), title.end(), title.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    std::string about = command.about.substr(0, command.about.find(". "));
    if (about.ends_with('.'))
        about.pop_back();
    if (about.starts_with(head.name + " "))
        about.erase(0, head.name.size() + 1); // "tessera - draws ..."
    std::string page = ".\\\" Written by the program's command `man`; do not edit.\n";
    page += ".TH " + typed(title) + " 1 \"" + head.date + "\" \"tessera " + head.version + "\" \"" +
            head.name + "\"\n";
    page += section("NAME", line(typed(pageOf(name)) + " \\- " + shown(about)));
    page += section("SYNOPSIS", synopsis(name, command));
    page += section("DESCRIPTION", line(shown(sentence(command.about))) + footer.sentences);
    page += section("ARGUMENTS", optionItems(command, true));
    page += section("OPTIONS", optionItems(command, false));
    page += section("COMMANDS", described);
    page += section("EXIT STATUS", kExitStatus);
    page += section("EXAMPLES", footer.example);
    return page + section("SEE ALSO", seeAlso);
}

} // namespace

std::map<std::string, std::string> manualPages(const CommandRow& program, const ManualHead& head) {
    std::map<std::string, std::string> pages;
    std::string list, others;
    for (const CommandRow& command : program.commands) {
        const std::string page = pageOf(program.name + " " + command.name);
        const std::string reference = ".BR " + typed(page) + " (1)";
        list += ".TP\n" + reference + "\n" + line(shown(sentence(command.about)));
        others += (others.empty() ? "" : ",\n") + reference; // "(1)," is one word
    }
    pages[program.name + ".1"] = manualPage(program.name, program, head, list, others + "\n");
    for (const CommandRow& command : program.commands) {
        const std::string name = program.name + " " + command.name;
        const std::string common = ".PP\nThe options of\n.BR " + typed(program.name) + " (1)\nhold, too.\n";
        std::string page = manualPage(name, command, head, nestedCommands(name, command),
                                      ".BR " + typed(program.name) + " (1)\n");
        page.insert(page.find(".SH EXIT STATUS"), common);
        pages[pageOf(name) + ".1"] = page;
    }
    return pages;
}

} // namespace tessera
