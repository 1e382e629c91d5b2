// tests/bricking/export/vti_test.cpp: VTK reads the image data that were written.
#include "tests/support/export_tools.h"

#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLImageDataReader.h>

namespace tessera::test {
namespace {

TEST(ExportVti, EveryTypeBoxAndLevelReadsBack) {
    forEachStoreToExport([](const StoreReader& store, const ScratchFolder& scratch, ValueType type) {
        for (const LevelBox& box : boxesFor(store.info()))
            for (const bool packed : {false, true}) {
                exportBox("vti", store, box, scratch / "v.vti", packed);
                const vtkNew<vtkXMLImageDataReader> reader;
                reader->SetFileName((scratch / "v.vti").c_str());
                reader->Update();
                vtkImageData* const image = reader->GetOutput();
                const std::vector<double> expected = expectedValues(store, box);
                vtkDataArray* const scalars = image->GetPointData()->GetScalars();
                ASSERT_TRUE(scalars);
                ASSERT_EQ(scalars->GetNumberOfTuples(), static_cast<vtkIdType>(expected.size()));
                EXPECT_STREQ(scalars->GetName(), "HU");
                const bool isFloat = scalars->GetDataType() == VTK_FLOAT;
                std::size_t wrong = 0;
                for (std::size_t i = 0; i < expected.size(); ++i)
                    wrong += scalars->GetComponent(static_cast<vtkIdType>(i), 0) !=
                             (isFloat ? static_cast<float>(expected[i]) : expected[i]);
                EXPECT_EQ(wrong, 0u) << name(type) << " level " << box.level << packed;
                std::vector<glm::dvec3> centres;
                for (const glm::dvec3& index : {glm::dvec3(0, 0, 0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
                    glm::dvec3 mm;
                    image->TransformContinuousIndexToPhysicalPoint(&index.x, &mm.x);
                    centres.push_back(mm);
                }
                expectPlace(store.info(), box, centres, 1e-9, "vti");
                fs::remove(scratch / "v.vti");
            }
    });
}

// A table of blocks whose last one is whole, and one that is not.
TEST(ExportVti, SeveralDeflatedBlocks) {
    for (const int z : {8, 9}) {
        const ScratchFolder scratch;
        HashSource source(plainInfo({512, 512, z}, ValueType::u8));
        import(scratch / "v.zarr", source);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        const LevelBox box = wholeLevel(store.info(), 0);
        exportBox("vti", store, box, scratch / "v.vti", true);
        const vtkNew<vtkXMLImageDataReader> reader;
        reader->SetFileName((scratch / "v.vti").c_str());
        reader->Update();
        const std::vector<double> expected = expectedValues(store, box);
        vtkDataArray* const scalars = reader->GetOutput()->GetPointData()->GetScalars();
        ASSERT_EQ(scalars->GetNumberOfTuples(), static_cast<vtkIdType>(expected.size()));
        for (std::size_t i = 0; i < expected.size(); ++i)
            ASSERT_EQ(scalars->GetComponent(static_cast<vtkIdType>(i), 0), expected[i]) << i;
    }
}

} // namespace
} // namespace tessera::test
