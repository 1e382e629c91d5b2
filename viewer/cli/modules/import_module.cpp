// viewer/cli/modules/import_module.cpp: the table of functions of tessera_importers.so.
#include "viewer/cli/modules/import_module.h"

extern "C" const tessera::ImportModule tesseraModule;
const tessera::ImportModule tesseraModule = {
    {TESSERA_VERSION},       tessera::lookThrough,         tessera::chooseRow,    tessera::phaseOf,
    tessera::openRow,        tessera::mayHaveLevels,       tessera::fileLevelsOf, tessera::tableOf,
    tessera::passedOverText, tessera::passesOverSomething, tessera::namedFilesOf, tessera::countPassed,
    tessera::keyOf,          tessera::openSource,          tessera::openLabels,   tessera::readStructureSet};
