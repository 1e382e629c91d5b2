// tests/bricking/import/files_test.cpp: properties of every format of single files, and the choice of the
// file that is opened.
#include "bricking/import/files/file_format.h"
#include "bricking/import/source/format_endings.h"
#include "tests/support/import_test_tools.h"

#include <cctype>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <set>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

TEST(ImportOpen, WhatIsNoVolumeIsRefusedWithThePathNamed) {
    const ScratchFolder folder;
    EXPECT_THAT(refusalOfOpening(folder / "missing.nii"), HasSubstr("missing.nii"));
    EXPECT_THAT(refusalOfOpening(folder / "missing"), HasSubstr("missing"));
    std::filesystem::create_directory(folder / "empty");
    EXPECT_THAT(refusalOfOpening(folder / "empty"), HasSubstr("empty"));
    std::filesystem::create_directory(folder / "texts");
    writeFile(folder / "texts" / "a.txt", "hello");
    writeFile(folder / "texts" / "b.txt", std::string(500, 'x'));
    EXPECT_THAT(refusalOfOpening(folder / "texts"), HasSubstr("2 files of other kinds"));
    EXPECT_THAT(refusalOfOpening(folder / "texts" / "a.txt"), HasSubstr("a.txt"));
    EXPECT_TRUE(listVolumes(folder / "texts").empty());
    EXPECT_TRUE(listVolumes(folder / "missing").empty());
}

TEST(ImportOpen, EveryFormatRefusesWhatHasItsNameOnly) {
    ASSERT_FALSE(fileFormats().empty());
    std::set<std::string> all;
    const ScratchFolder folder;
    for (const FileFormat& format : fileFormats()) {
        ASSERT_TRUE(!format.endings.empty() || format.isFolder) << format.named;
        for (const std::string& ending : format.endings) {
            EXPECT_TRUE(all.insert(ending).second) << ending << " is of two formats";
            EXPECT_EQ(fileFormatOf("a.b" + ending), &format);
            EXPECT_EQ(fileFormatOf("A" + ending.substr(0, 1) +
                                   static_cast<char>(std::toupper(static_cast<unsigned char>(ending[1]))) +
                                   ending.substr(2)),
                      &format);
            EXPECT_EQ(fileFormatOf(ending), nullptr) << "a name that is an ending";
            for (const std::string content : {"", "no", "{}"}) {
                writeFile(folder / ("x" + ending), content);
                EXPECT_THAT(refusalOfOpening(folder / ("x" + ending)), HasSubstr("x" + ending)) << content;
            }
        }
    }
    EXPECT_THAT(volumeFileEndings(), ::testing::UnorderedElementsAreArray(all));
    std::filesystem::create_directory(folder / "empty");
    const std::string ofFolder = refusalOfOpening(folder / "empty");
    writeFile(folder / "a.txt", "hello");
    const std::string ofFile = refusalOfOpening(folder / "a.txt");
    EXPECT_THAT(ofFolder, HasSubstr("expected DICOM slices, "));
    EXPECT_THAT(ofFile, HasSubstr("expected a DICOM file or folder, "));
    for (const FileFormat& format : fileFormats()) {
        EXPECT_THAT(ofFolder, HasSubstr(format.inFolders)); // "" where folders are not looked through for it
        EXPECT_THAT(ofFile, HasSubstr(format.named));
    }
    const auto lastInFolders = std::find_if(fileFormats().rbegin(), fileFormats().rend(),
                                            [](const FileFormat& f) { return !f.inFolders.empty(); });
    EXPECT_THAT(ofFolder, HasSubstr(" or " + lastInFolders->inFolders + ", found"));
    EXPECT_THAT(ofFile, HasSubstr(" or " + fileFormats().back().named + ", "));
}

TEST(ImportOpen, ListsFilesLargestFirst) {
    const ScratchFolder folder;
    std::filesystem::create_directory(folder / "deep");
    NiftiImage image;
    image.voxels = std::string(48, '\0');
    writeFile(folder / "deep" / "small.nii", niftiBytes(image));
    image.extent = {4, 4, 4};
    image.voxels = std::string(128, '\0');
    writeFile(folder / "large.nii.gz", gzip(niftiBytes(image)));
    writeFile(folder / "broken.nii", "no");
    writeFile(folder / "package.json", R"({"name":"no volume"})");
    const auto found = listVolumes(folder.path());
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].path.filename(), "large.nii.gz");
    EXPECT_EQ(found[1].path.filename(), "small.nii");
    EXPECT_EQ(found[1].info.extentVoxels, glm::ivec3(2, 3, 4));
}

} // namespace
} // namespace tessera::test
