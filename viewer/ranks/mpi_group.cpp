// viewer/ranks/mpi_group.cpp: see mpi_group.h.
#include "viewer/ranks/mpi_group.h"

#include "core/base/error.h"

#include <IceT.h>
#include <IceTMPI.h>
#include <cstdlib>
#include <mpi.h>
#include <type_traits>

namespace tessera {
namespace {

int exitCode = 0; // of a process that failed

/// What a process that failed had to say has been said.
void leave() {
    if (exitCode != 0)
        MPI_Abort(MPI_COMM_WORLD, exitCode);
    MPI_Finalize();
}

class MpiGroup : public ProcessGroup {
  public:
    MpiGroup() {
        int provided = 0;
        MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
        std::atexit(leave);
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
        MPI_Comm_size(MPI_COMM_WORLD, &size_);
        MPI_Type_contiguous(4, MPI_FLOAT, &pixel_);
        MPI_Type_commit(&pixel_);
        const IceTCommunicator all = icetCreateMPICommunicator(MPI_COMM_WORLD);
        icetCreateContext(all);
        icetDestroyMPICommunicator(all); // the context has its own
        icetDiagnostics(ICET_DIAG_OFF);  // they are printed to stdout
        icetSetColorFormat(ICET_IMAGE_COLOR_RGBA_FLOAT);
        icetSetDepthFormat(ICET_IMAGE_DEPTH_NONE);
        icetCompositeMode(ICET_COMPOSITE_MODE_BLEND);
        icetEnable(ICET_ORDERED_COMPOSITE);
        icetStrategy(ICET_STRATEGY_SEQUENTIAL); // of one tile
        icetSingleImageStrategy(ICET_SINGLE_IMAGE_STRATEGY_RADIXK);
        check("a context of IceT");
    }

    int rank() const override { return rank_; }
    int size() const override { return size_; }

    std::uint64_t least(std::uint64_t mine) override {
        std::uint64_t least = 0;
        MPI_Allreduce(&mine, &least, 1, MPI_UINT64_T, MPI_MIN, MPI_COMM_WORLD);
        return least;
    }

    void composite(std::span<glm::vec4> pixels, const glm::ivec2& size, std::span<const int> order) override {
        if (size_ == 1)
            return;
        icetResetTiles();
        icetAddTile(0, 0, size.x, size.y, 0);
        icetCompositeOrder(order.data());
        constexpr float kNothing[4] = {};
        const IceTImage whole =
            icetCompositeImage(pixels.data(), nullptr, nullptr, nullptr, nullptr, kNothing);
        check("the composite of all parts");
        if (rank_ == 0)
            icetImageCopyColorf(whole, &pixels.front().x, ICET_IMAGE_COLOR_RGBA_FLOAT);
        check("the composite's colours");
        MPI_Bcast(pixels.data(), static_cast<int>(pixels.size()), pixel_, 0, MPI_COMM_WORLD);
    }

    std::vector<PartReport> gather(const PartReport& mine) override {
        static_assert(std::is_trivially_copyable_v<PartReport>);
        std::vector<PartReport> all(rank_ == 0 ? static_cast<std::size_t>(size_) : 0);
        MPI_Gather(&mine, sizeof mine, MPI_BYTE, all.data(), sizeof mine, MPI_BYTE, 0, MPI_COMM_WORLD);
        return all;
    }

    void fail(int code) override { exitCode = code; }

  private:
    static void check(const char* expected) {
        if (const IceTEnum error = icetGetError(); error != ICET_NO_ERROR)
            throw badFile("IceT", expected, "its error " + std::to_string(error));
    }

    int rank_ = 0, size_ = 1;
    MPI_Datatype pixel_ = MPI_DATATYPE_NULL;
};

} // namespace

ProcessGroup& joinRanks() {
    static MpiGroup& group = *new MpiGroup; // what is called at the program's end reads it
    return group;
}

} // namespace tessera
