// core/scene/source_choice.h: the choice of one volume among source files, and the options to open it.
#pragma once

namespace tessera {

struct SourceChoice {
    int series = 0;            // DICOM: number in the table of series; 0: none chosen
    bool resampleZ = false;    // uneven slices are interpolated
    bool largest = false;      // a folder's largest CT, or its largest volume if there is no CT
    int phase = 0;             // of a series with several images at each position; 0: none chosen
    bool allowMissing = false; // files that could be slices and cannot be read are left out
    bool operator==(const SourceChoice&) const = default;
};

} // namespace tessera
