// viewer/cli/modules/ranks_on_demand.cpp: viewer/ranks/mpi_group.h for programs: --ranks loads MPI and IceT.
#include "viewer/cli/modules/ranks_module.h"

namespace tessera {

ProcessGroup& joinRanks() {
    static const auto* const table = static_cast<const RanksModule*>(loadModule("tessera_ranks"));
    return table->join();
}

} // namespace tessera
