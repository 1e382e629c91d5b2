// viewer/cli/options/options.h: options and output that all commands share: verbosity, budgets, notes to
// stderr.
#pragma once

#include "core/base/budget.h"
#include "core/base/progress.h"

#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

struct CommonOptions {
    bool quiet = false, verbose = false;
    Verbosity verbosity() const {
        return quiet ? Verbosity::quiet : verbose ? Verbosity::verbose : Verbosity::normal;
    }
    /// Progress of a long job; set once the options are parsed.
    std::shared_ptr<Progress> progress = std::make_shared<Progress>();
    /// Of one of several pieces of work: what its notes and problems begin with ("p-17: "), and the progress
    /// that prints them; null: its own.
    std::string prefix = {};
    std::shared_ptr<Progress> shared = {};
    /// A line on stderr, unless --quiet. Results go to stdout.
    void note(const std::string& line) const;
    /// A line on stderr with --verbose only.
    void detail(const std::string& line) const;
    /// printProblem(), with the prefix: also with --quiet.
    void problem(const std::string& message) const;
    /// Gets the lines of note() and problem() in place of stderr, from the thread that does the work. None:
    /// stderr.
    std::function<void(const std::string& line)> listener = {};
    /// Objects that live until the command ends, such as a lock or a temporary folder.
    void keep(std::shared_ptr<void> thing) const { kept->push_back(std::move(thing)); }
    std::shared_ptr<std::vector<std::shared_ptr<void>>> kept =
        std::make_shared<std::vector<std::shared_ptr<void>>>();
};

/// "tessera: message" on stderr, always; in colour on a terminal unless NO_COLOR is set. Control characters
/// other than line feeds are escaped.
void printProblem(const std::string& message);

/// Bytes of an option's text; empty text: 1 GiB, or half of the available memory if that is less. Throws
/// InputError naming the option.
std::size_t budgetBytes(const std::string& text, const std::string& option, const CommonOptions& common);

/// "512 x 512 x 134"
std::string formatExtent(const glm::ivec3& extent);
/// As numberText() (core/base/shown_text.h).
std::string formatNumber(double number, int digits = 4);

} // namespace tessera
