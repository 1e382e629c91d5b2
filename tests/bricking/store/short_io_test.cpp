// tests/bricking/store/short_io_test.cpp: the system may read or write less than requested, as on network
// file systems and in calls of two gigabytes. The rest is requested again from where it stopped.
#include "bricking/store/store_files.h"
#include "core/base/output_file.h"
#include "tests/support/bricking_test_volumes.h"

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {
thread_local std::size_t mostAtOnce = SIZE_MAX; // bytes that a call moves
} // namespace

// In place of the C library's, in this program.
extern "C" ssize_t pread(int file, void* bytes, std::size_t count, off_t offset) {
    return ::syscall(SYS_pread64, file, bytes, std::min(count, mostAtOnce), offset);
}
extern "C" ssize_t pwrite(int file, const void* bytes, std::size_t count, off_t offset) {
    return ::syscall(SYS_pwrite64, file, bytes, std::min(count, mostAtOnce), offset);
}

namespace tessera {
namespace {

class ShortReadsAndWrites : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Bytes, ShortReadsAndWrites, testing::Values(7, 1));

TEST_P(ShortReadsAndWrites, AreGoneOnWith) {
    const ScratchFolder folder;
    std::string text;
    for (int i = 0; i < 100; ++i)
        text += static_cast<char>('!' + i % 90);
    const auto bytes = std::as_bytes(std::span(text));
    mostAtOnce = GetParam();
    writeFile(folder / "a", text);
    {
        const FileHandle file = openForWriting(folder / "b");
        writeAt(file, 3, bytes, folder / "b");
    }
    writeOutputFile(folder / "c", text);
    std::string read(90, '\0');
    readAt(*openIn(openFolder(folder.path()), "a", folder.path()), 10,
           std::as_writable_bytes(std::span(read)), "a");
    mostAtOnce = SIZE_MAX;
    EXPECT_EQ(test::fileText(folder / "a"), text);
    EXPECT_EQ(test::fileText(folder / "b"), std::string(3, '\0') + text);
    EXPECT_EQ(test::fileText(folder / "c"), text);
    EXPECT_EQ(read, text.substr(10));
}

} // namespace
} // namespace tessera
