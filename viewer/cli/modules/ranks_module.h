// viewer/cli/modules/ranks_module.h: the function of viewer/ranks/mpi_group.h, as the table of a module.
#pragma once

#include "viewer/cli/modules/load_module.h"
#include "viewer/ranks/mpi_group.h"

namespace tessera {

struct RanksModule {
    ModuleHead head;
    decltype(&joinRanks) join;
};

} // namespace tessera
