// viewer/ranks/mpi_group.h: the processes that mpirun started together, as a ProcessGroup: pictures are
// composited by IceT, over MPI. Without mpirun the group is this process alone.
#pragma once

#include "render/parts/process_group.h"

namespace tessera {

/// The group, which stays until the program ends. The caller's thread must make all of its calls.
ProcessGroup& joinRanks();

} // namespace tessera
