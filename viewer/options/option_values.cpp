// viewer/options/option_values.cpp: see option_values.h.
#include "viewer/options/option_values.h"

#include "core/error.h"

#include <charconv>
#include <cmath>
#include <cstdlib>

namespace tessera {
namespace {

std::string refusal(const std::string& expected, const std::string& found) {
    constexpr std::size_t kShown = 40;
    return "expected " + expected + ", found \"" + found.substr(0, kShown) + "\"";
}

} // namespace

CLI::Validator wholeNumberFrom(int lowest) {
    const auto check = [lowest](std::string& text) {
        int number = 0;
        const char* const end = text.data() + text.size();
        const auto [stopped, error] = std::from_chars(text.data(), end, number);
        return error == std::errc() && stopped == end && number >= lowest
                   ? std::string()
                   : refusal("a whole number from " + std::to_string(lowest), text);
    };
    return CLI::Validator(check, "");
}

CLI::Validator numberWithin(double lowest, double highest, const std::string& what) {
    const auto check = [lowest, highest, what](std::string& text) {
        char* end = nullptr;
        const double number = std::strtod(text.c_str(), &end);
        const bool whole = !text.empty() && *end == '\0' && std::isfinite(number);
        return whole && number >= lowest && number <= highest ? std::string() : refusal(what, text);
    };
    return CLI::Validator(check, "");
}

void refuseEmptyValues(const CLI::App& program) {
    for (const CLI::Option* option : program.get_options())
        for (const std::string& value : option->results())
            if (value.empty())
                throw badFile(option->get_name(), option->get_description(), "\"" + value + "\"");
    for (const CLI::App* command : program.get_subcommands())
        refuseEmptyValues(*command);
}

} // namespace tessera
