// viewer/cli/modules/import_module.h: the importers' functions for the program, as the table of a module.
#pragma once

#include "bricking/import/catalogue.h"
#include "bricking/import/labels/open_labels.h"
#include "bricking/import/open_source.h"
#include "bricking/import/structures/structure_set.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct ImportModule {
    ModuleHead head;
    decltype(&lookThrough) look;
    decltype(&chooseRow) choose;
    decltype(&phaseOf) phase;
    decltype(&openRow) open;
    decltype(&mayHaveLevels) mayHave;
    decltype(&fileLevelsOf) levels;
    decltype(&tableOf) table;
    decltype(&passedOverText) passedOver;
    decltype(&passesOverSomething) passesOver;
    decltype(&namedFilesOf) namedFiles;
    decltype(&countPassed) count;
    decltype(&keyOf) key;
    decltype(&openSource) openPath;
    decltype(&openLabels) openLabelled;
    decltype(&readStructureSet) readStructures;
};

} // namespace tessera
