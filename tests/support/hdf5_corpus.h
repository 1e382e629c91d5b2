// tests/support/hdf5_corpus.h: the small HDF5 files that h5py wrote (tests/interop/hdf5/corpus.py), and what
// is in them.
#pragma once

#include "bricking/import/files/file_format.h"
#include "core/base/program_folders.h"
#include "tests/support/import_test_tools.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera::test {

inline std::filesystem::path hdf5Corpus() {
    return sourceFolder() / "tests/fuzz/corpus/hdf5";
}

/// Sorted by name; those that are refused for what they hold, or all others.
inline std::vector<std::filesystem::path> hdf5Files(bool areRefused) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(hdf5Corpus()))
        if (const std::string ending = entry.path().extension(); ending == ".h5" || ending == ".ims")
            if (entry.path().filename().string().starts_with("refused_") == areRefused)
                files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
}

/// The volumes of a file at all times, each with its name; spacing is given where the file does not say it.
struct Hdf5Volume {
    std::string name;
    std::unique_ptr<SlabSource> source;
};
inline std::vector<Hdf5Volume> openHdf5Volumes(const std::filesystem::path& path) {
    const FileFormat& format = *fileFormatOf(path);
    std::vector<FileVolume> all = format.volumes(path);
    if (all.empty())
        all = {{"", {0}}};
    std::vector<Hdf5Volume> volumes;
    for (const FileVolume& one : all)
        for (std::size_t time = 0; time < one.numbers.size(); ++time) {
            const std::string name = one.name + (one.times.empty() ? "" : ", " + one.times[time]);
            SourceOptions options;
            options.series = one.numbers[time];
            try {
                volumes.push_back({name, format.open(path, options)});
            } catch (const InputError&) {
                options.spacingMm = glm::dvec3(1);
                volumes.push_back({name, format.open(path, options)});
            }
        }
    return volumes;
}

/// As doubles.
inline std::vector<double> valuesOf(SlabSource& source) {
    return withValueType(source.info().type, [&](auto typed) {
        const auto read = readAll<decltype(typed)>(source);
        return std::vector<double>(read.begin(), read.end());
    });
}

} // namespace tessera::test
