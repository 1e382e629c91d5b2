// tests/support/dicom_series.h: a folder with a series of slices, as scanners name them.
#pragma once

#include "core/base/program_folders.h"
#include "tests/support/dicom_writer.h"

#include <cstdint>
#include <cstdio>
#include <gtest/gtest.h>
#include <string>

namespace tessera::test {

/// A CT of five slices of 4 x 3 pixels, 2 mm apart: IM0041.dcm to IM0045.dcm.
class DicomSeries : public ::testing::Test {
  protected:
    static constexpr int kSlices = 5;

    /// @param n  2 mm each
    static DicomImage imageAt(double n, const std::string& series = "1") {
        DicomImage image;
        image.position = glm::dvec3(-1, 2, 2 * n);
        image.series = series;
        image.pixels.assign(12, static_cast<std::uint16_t>(1024 + 100 * n));
        return image;
    }
    static std::string nameOf(int number) {
        char name[32];
        std::snprintf(name, sizeof name, "IM%04d.dcm", number);
        return name;
    }
    void writeSeries() {
        for (int n = 0; n < kSlices; ++n)
            writeDicom(folder / nameOf(41 + n), imageAt(n));
    }
    ScratchFolder folder;
};

} // namespace tessera::test
