// tests/program/modules_test.cpp: modules that the program loads on demand are parts of it. Their errors are
// the program's errors, Ctrl-C ends them, and a missing or wrong module is reported.
#include "viewer/cli/modules/load_module.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/program_folders.h"
#include "core/image/image_file.h"
#if TESSERA_WITH_ENVIRONMENTS
#include "core/image/environment_file.h"
#endif
#if TESSERA_WITH_IMPORT
#include "bricking/import/catalogue.h"
#include "tests/support/dicom_writer.h"
#endif

#include <csignal>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string said(const std::function<void()>& body) {
    try {
        body();
    } catch (const Error& error) {
        return error.what();
    }
    return "no Error";
}

TEST(Modules, ErrorsOfPicturesAreOurs) {
    const ScratchFolder folder;
    std::ofstream(folder / "text.exr") << "no picture";
    try {
        readImage(folder / "text.exr");
        FAIL() << "a text was a picture";
    } catch (const BadFile& error) { // with all that it carries
        EXPECT_THAT(error.what(), HasSubstr("text.exr"));
        EXPECT_EQ(error.expected(), "a readable picture");
    }
    // Thrown by the program's own OutputFile, below the module.
    EXPECT_THROW(writeImage(folder / "missing" / "a.png", Image(glm::ivec2(2, 2)), ""), InputError);
    EXPECT_THROW(checkImagePath("a.jpg"), BadFile);
    writeImage(folder / "a.png", Image(glm::ivec2(2, 2)), "manifest");
    EXPECT_EQ(readManifest(folder / "a.png"), "manifest");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2);
}

#if TESSERA_WITH_ENVIRONMENTS
TEST(Modules, ErrorsOfEnvironmentsAreOurs) {
    const ScratchFolder folder;
    std::ofstream(folder / "text.hdr") << "no picture";
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    try {
        readEnvironment(folder / "text.hdr", ram);
        FAIL() << "a text was an environment";
    } catch (const BadFile& error) {
        EXPECT_EQ(error.found(), "another file");
    }
}
#endif

TEST(Modules, WhatIsMissingOrAnotherIsNamed) {
    EXPECT_THAT(said([] { loadModule("tessera_nothing"); }),
                HasSubstr("tessera_nothing.so: expected a module of tessera"));
    const fs::path text = fs::read_symlink("/proc/self/exe").parent_path() / "tessera_no_module_test.so";
    std::ofstream(text) << "no library";
    EXPECT_THAT(said([] { loadModule("tessera_no_module_test"); }), HasSubstr("one that cannot be loaded"));
    fs::remove(text);
}

#if TESSERA_WITH_IMPORT
TEST(Modules, ErrorsOfImportersAreOurs) {
    const ScratchFolder folder;
    EXPECT_THROW(lookThrough(folder / "nothing"), InputError);
    std::ofstream(folder / "a.txt") << "no scan";
    const Catalogue catalogue = lookThrough(folder.path());
    EXPECT_THROW(chooseRow(catalogue, {}), InputError);
}

// The module's loops ask the program, which caught the signal. A copy of core/base/interrupt.cpp in the
// module would know of none.
TEST(Modules, CtrlCEndsWhatAModuleDoes) {
    const ScratchFolder folder;
    DicomImage image;
    image.columns = image.rows = 4;
    image.pixels.assign(16, 1024);
    writeDicom(folder / "a.dcm", image);
    EXPECT_EQ(lookThrough(folder.path()).rows.size(), 1u);
    const pid_t child = ::fork();
    if (child == 0) {
        catchInterrupts();
        ::raise(SIGINT);
        try {
            lookThrough(folder.path());
        } catch (const Interrupted& interrupted) {
            ::_exit(interrupted.exitCode());
        } catch (...) {
            ::_exit(2);
        }
        ::_exit(1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 128 + SIGINT);
}
#endif

} // namespace
} // namespace tessera::test
