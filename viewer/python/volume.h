// viewer/python/volume.h: a volume that Python holds: a store, the import of source files in the cache, or
// the import of an array in a temporary store, which goes with it.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <string>
#include <vector>

namespace tessera::python {

namespace py = pybind11;

class Volume {
  public:
    /// @param kept  what must live as long: locks of the cache, a temporary store
    Volume(const std::filesystem::path& store, std::size_t ramBytes, std::vector<std::shared_ptr<void>> kept);

    const StoreReader& store() const { return *store_; }
    /// The store's, with the unit that was given.
    const VolumeInfo& info() const { return info_; }
    MemoryBudget& ram() { return ram_; }
    /// Of values whose source says none. Throws InputError naming it where the source says another.
    void setUnit(const std::string& unit);

    std::vector<std::string> notes = {}; // of its import

  private:
    std::vector<std::shared_ptr<void>> kept_;
    MemoryBudget ram_;
    std::unique_ptr<StoreReader> store_;
    VolumeInfo info_;
};

/// Adds Volume, what opens one, and what removes the temporary stores that are left when Python ends.
void addVolumes(py::module_& module);

} // namespace tessera::python
