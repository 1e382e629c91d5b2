// viewer/cli/modules/ranks_module.cpp: the table of functions of tessera_ranks.so.
#include "viewer/cli/modules/ranks_module.h"

extern "C" const tessera::RanksModule tesseraModule;
const tessera::RanksModule tesseraModule = {{TESSERA_VERSION}, tessera::joinRanks};
