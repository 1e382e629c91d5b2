// tests/support/vtk_volume.h: the voxels of a file as a reader of VTK gives them, of the whole volume at
// once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <vector>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>

namespace tessera::test {

/// In the order of the file, whatever VTK takes for channels; empty: VTK has other numbers of bytes a value.
template <class T, class Reader> std::vector<T> vtkVoxels(const std::filesystem::path& path) {
    vtkNew<Reader> reader;
    reader->SetFileName(path.c_str());
    reader->UpdateWholeExtent();
    vtkDataArray* const values = reader->GetOutput()->GetPointData()->GetScalars();
    if (!values || values->GetDataTypeSize() != static_cast<int>(sizeof(T)))
        return {};
    const T* const from = static_cast<const T*>(values->GetVoidPointer(0));
    return std::vector<T>(from, from + values->GetNumberOfValues());
}

} // namespace tessera::test
