// bricking/import/source/phase_choice.h: the choice among the phases of a file: volumes of one place at
// several times, of which SourceOptions::phase takes one.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tessera {

/// "time 1", "time 2"; with a distance in time "0 s", "2.5 s".
std::vector<std::string> phaseLabels(std::size_t count, double stepSeconds = 0);

/// "12 phases (1: 0 s, 2: 2.5 s, ...)": the first 24.
/// @param words  behind "phases": " for --phase"
std::string phasesText(const std::vector<std::string>& labels, const std::string& words = {});

/// The number of the phase, from 0.
/// @param labels  of all; empty: the file has one volume
/// @param wanted  from 1; 0: none is chosen
/// Throws InputError naming `where`, with the list, for a choice that is missing, or that there is not.
std::size_t chosenPhase(const std::vector<std::string>& labels, int wanted, const std::string& where);

} // namespace tessera
