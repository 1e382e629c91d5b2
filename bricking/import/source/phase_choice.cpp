// bricking/import/source/phase_choice.cpp: see phase_choice.h.
#include "bricking/import/source/phase_choice.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>

namespace tessera {

std::vector<std::string> phaseLabels(std::size_t count, double stepSeconds) {
    std::vector<std::string> labels;
    for (std::size_t n = 0; n < count; ++n)
        labels.push_back(stepSeconds > 0 ? numberText(static_cast<double>(n) * stepSeconds, 6) + " s"
                                         : "time " + std::to_string(n + 1));
    return labels;
}

std::string phasesText(const std::vector<std::string>& labels, const std::string& words) {
    constexpr std::size_t kMostListed = 24;
    std::string list;
    for (std::size_t n = 0; n < std::min(labels.size(), kMostListed); ++n)
        list += (n == 0 ? "" : ", ") + std::to_string(n + 1) + ": " + labels[n];
    return std::to_string(labels.size()) + " phases" + words + " (" + list +
           (labels.size() > kMostListed ? ", ...)" : ")");
}

std::size_t chosenPhase(const std::vector<std::string>& labels, int wanted, const std::string& where) {
    if (labels.size() < 2) {
        if (wanted != 0)
            throw badFile(where, "several phases for --phase to choose from", "one volume");
        return 0;
    }
    if (wanted == 0)
        throw badFile(where, "one volume, or a choice with --phase N", phasesText(labels));
    if (wanted < 1 || static_cast<std::size_t>(wanted) > labels.size())
        throw badFile(where, "--phase between 1 and " + std::to_string(labels.size()),
                      std::to_string(wanted) + " of " + phasesText(labels));
    return static_cast<std::size_t>(wanted) - 1;
}

} // namespace tessera
