// tests/bricking/remote/remote_test.cpp: files behind an address: every range as the file has it, whatever
// fails on the way; blocks on disk, their budget and damage; what is refused; a store behind an address.
#include "bricking/remote/block_files.h"
#include "bricking/remote/http_files.h"
#include "bricking/statistics/coarse_statistics.h"
#include "bricking/store/store_reader.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "core/base/threads.h"
#include "tests/support/bricking_store_tools.h"
#include "tests/support/http_server.h"
#include "tests/support/refusals.h"

#include <cstdlib>
#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Fault = HttpServer::Fault;

std::string randomBytes(std::size_t count, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::string bytes(count, '\0');
    for (char& byte : bytes)
        byte = static_cast<char>(random());
    return bytes;
}

void writeBytes(const fs::path& path, const std::string& bytes) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << bytes;
}

std::uint64_t bytesIn(const fs::path& folder) {
    std::uint64_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        bytes += entry.is_regular_file() ? entry.file_size() : 0;
    return bytes;
}

std::string read(RemoteFiles& files, const std::string& name, std::uint64_t offset, std::size_t count) {
    std::string bytes(count, '\0');
    files.readAt(name, offset, std::as_writable_bytes(std::span(bytes)));
    return bytes;
}

struct Remote : ::testing::Test {
    const ScratchFolder served, kept;
    HttpServer server{served.path()};
    RemoteOptions options{kept / "blocks", std::uint64_t{1} << 30, std::chrono::milliseconds(1)};
    std::shared_ptr<RemoteFiles> open(const std::string& below = "a") {
        return openRemoteFiles(server.address(below), options);
    }
};

TEST_F(Remote, EveryRangeIsThatOfTheFile) {
    std::mt19937 random(3);
    for (const std::size_t size : {std::size_t{1}, kRemoteBlockBytes - 1, kRemoteBlockBytes,
                                   kRemoteBlockBytes + 1, 11 * kRemoteBlockBytes + 77}) {
        const std::string bytes = randomBytes(size);
        writeBytes(served / "a" / std::to_string(size), bytes);
        const auto files = open();
        EXPECT_EQ(files->sizeOf(std::to_string(size)), size);
        for (int i = 0; i < 40; ++i) {
            const std::size_t offset = random() % size, count = random() % (size - offset + 1);
            ASSERT_EQ(read(*files, std::to_string(size), offset, count), bytes.substr(offset, count));
        }
        EXPECT_EQ(read(*files, std::to_string(size), 0, size), bytes);
        EXPECT_THAT(refusalOf([&] { read(*files, std::to_string(size), size, 1); }), HasSubstr("a file of"));
        EXPECT_THAT(refusalOf([&] { read(*files, std::to_string(size), 1, size); }), HasSubstr("a file of"));
    }
    EXPECT_EQ(open()->sizeOf("none"), std::nullopt);
    writeBytes(served / "a" / "empty", "");
    EXPECT_EQ(open()->sizeOf("empty"), 0u);
    writeBytes(served / "a" / "b c" / "d%#?&.x", "odd");
    EXPECT_EQ(read(*open(), "b c/d%#?&.x", 0, 3), "odd");
}

TEST_F(Remote, WhatFailsForAWhileIsAskedForAgain) {
    const std::string bytes = randomBytes(40 * kRemoteBlockBytes + 5);
    writeBytes(served / "a" / "file", bytes);
    std::mutex mutex;
    std::mt19937 random(7);
    server.delay = std::chrono::milliseconds(2);
    server.fault = [&](int, const AskedOf&) {
        const std::lock_guard lock(mutex);
        const auto drawn = random() % 15; // a fifth of all fails, in three ways
        return drawn == 0   ? Fault::unavailable
               : drawn == 1 ? Fault::closed
               : drawn == 2 ? Fault::cut
                            : Fault::none;
    };
    const auto files = open();
    parallelFor(60, 8, [&](std::size_t i) {
        const std::size_t offset = i * 7919 * 11 % (bytes.size() - 9999);
        EXPECT_EQ(read(*files, "file", offset, 9999), bytes.substr(offset, 9999));
    });
    EXPECT_EQ(read(*files, "file", 0, bytes.size()), bytes);
    EXPECT_GT(files->counters().retries, 2u);
    EXPECT_LE(files->counters().bytesFetched, bytes.size() * 3 / 2) << "blocks are fetched once";
}

TEST_F(Remote, BlocksAreKeptFromRunToRunUntilTheFileChanges) {
    std::string bytes = randomBytes(3 * kRemoteBlockBytes);
    writeBytes(served / "a" / "file", bytes);
    EXPECT_EQ(read(*open(), "file", 0, bytes.size()), bytes);
    const std::size_t sent = server.bytesSent();
    EXPECT_EQ(sent, bytes.size());
    const auto again = open();
    EXPECT_EQ(read(*again, "file", 0, bytes.size()), bytes);
    EXPECT_EQ(server.bytesSent(), sent) << "the server says that it is as known";
    EXPECT_EQ(again->counters().bytesFromDisk, bytes.size());
    bytes = randomBytes(3 * kRemoteBlockBytes, 2);
    writeBytes(served / "a" / "file", bytes);
    EXPECT_EQ(read(*open(), "file", 0, bytes.size()), bytes);
    // Changed while it is read: one picture is not made of two files.
    options.blockFolder.clear();
    const auto reading = open();
    EXPECT_EQ(read(*reading, "file", 0, 9), bytes.substr(0, 9));
    writeBytes(served / "a" / "file", randomBytes(3 * kRemoteBlockBytes, 3));
    EXPECT_THAT(refusalOf([&] { read(*reading, "file", 2 * kRemoteBlockBytes, 9); }), HasSubstr("another"));
}

TEST_F(Remote, AServerWithoutVersionsIsAskedAnewInEveryRun) {
    server.hasVersions = false;
    writeBytes(served / "a" / "file", "first");
    EXPECT_EQ(read(*open(), "file", 0, 5), "first");
    writeBytes(served / "a" / "file", "other");
    EXPECT_EQ(read(*open(), "file", 0, 5), "other");
}

TEST_F(Remote, KeptBlocksStayWithinTheirBudgetAndDamageIsFetchedAgain) {
    const std::string bytes = randomBytes(20 * kRemoteBlockBytes);
    writeBytes(served / "a" / "file", bytes);
    options.blockBytes = 6 * (kRemoteBlockBytes + 4);
    const auto files = open();
    EXPECT_EQ(read(*files, "file", 0, bytes.size()), bytes);
    EXPECT_LE(bytesIn(options.blockFolder), options.blockBytes);
    EXPECT_GT(bytesIn(options.blockFolder), options.blockBytes / 2);
    for (const auto& entry : fs::recursive_directory_iterator(options.blockFolder))
        if (entry.is_regular_file()) {
            std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
            file.seekp(static_cast<std::streamoff>(entry.file_size() / 2));
            file.put('\x55');
        }
    EXPECT_EQ(read(*files, "file", 0, bytes.size()), bytes);
    EXPECT_EQ(read(*open(), "file", 0, bytes.size()), bytes);
    options.blockBytes = 0;
    EXPECT_EQ(read(*open(), "file", 0, bytes.size()), bytes);
    EXPECT_EQ(bytesIn(options.blockFolder), 0u);
    options.blockFolder = "/proc/no/such/folder";
    EXPECT_EQ(read(*open(), "file", 0, bytes.size()), bytes);
}

TEST_F(Remote, WhatCannotBeReadIsRefusedByItsAddress) {
    writeBytes(served / "a" / "file", randomBytes(2 * kRemoteBlockBytes));
    server.statuses["/a/file"] = 401;
    EXPECT_THAT(refusalOf([&] { open()->sizeOf("file"); }), AllOf(HasSubstr("/a/file"), HasSubstr("401")));
    server.statuses["/a/file"] = 500;
    EXPECT_THAT(refusalOf([&] { open()->sizeOf("file"); }), AllOf(HasSubstr("500"), HasSubstr("8 tries")));
    server.statuses.clear();
    server.hasRanges = false;
    EXPECT_THAT(refusalOf([&] { open()->sizeOf("file"); }), HasSubstr("ranges"));
    writeBytes(served / "a" / "short", "short");
    EXPECT_EQ(read(*open(), "short", 1, 3), "hor");
    server.fault = [](int, const AskedOf&) { return Fault::closed; };
    const auto files = open();
    EXPECT_THAT(refusalOf([&] { files->sizeOf("short"); }), HasSubstr("a server that answers"));
    const std::size_t asked = server.asked().size();
    EXPECT_THAT(refusalOf([&] { files->sizeOf("file"); }), HasSubstr("a moment ago"));
    EXPECT_EQ(server.asked().size(), asked) << "it is left in peace for a while";
    EXPECT_THAT(refusalOf([&] { openRemoteFiles("https://", options); }), HasSubstr("host"));
}

TEST_F(Remote, SecretsGoWithRequestsAndIntoNoMessage) {
    writeBytes(served / "a" / "file", "hello");
    std::string address = server.address("a/") + "?token=abc";
    address.insert(7, "user:pass@");
    const auto files = openRemoteFiles(address, options);
    EXPECT_EQ(read(*files, "file", 0, 5), "hello");
    EXPECT_EQ(server.asked().front().target, "/a/file?token=abc");
    EXPECT_THAT(server.asked().front().authorization, HasSubstr("Basic"));
    server.statuses["/a/none?token=abc"] = 401;
    EXPECT_THAT(refusalOf([&] { files->sizeOf("none"); }),
                AllOf(HasSubstr("/a/none"), Not(HasSubstr("pass")), Not(HasSubstr("abc"))));
    EXPECT_EQ(withoutSecrets("https://u:p@h/a@b/c?x#y"), "https://h/a@b/c");
    EXPECT_EQ(withoutSecrets("https://h"), "https://h");
    EXPECT_EQ(withoutSecrets("https://h:80/a@b"), "https://h:80/a@b");
    EXPECT_EQ(withoutSecrets("https://[::1]:80/a"), "https://[::1]:80/a");
    EXPECT_EQ(withoutSecrets("HTTPS://u:p@H/a"), "https://H/a");
    for (const char odd : {'/', '?', '#', '@'}) // in a password, not escaped
        EXPECT_EQ(withoutSecrets(std::string("https://user:pa") + odd + "ss@h/x?t=1"), "https://h/x") << odd;
    EXPECT_TRUE(isAddress("HTTPS://h") && isAddress("S3://b") && !isAddress("https:/h"));
    EXPECT_EQ(shownName("https://u:p@h/ct.zarr?token=a.b"), "ct.zarr");
}

// Storage that lists no names forbids what is not there, and what the reader may not have.
TEST_F(Remote, WhatIsForbiddenIsNotThereWhileOthersCanBeRead) {
    writeBytes(served / "a" / "file", "hello");
    writeBytes(served / "a" / "shard", randomBytes(2 * kRemoteBlockBytes));
    server.statuses["/a/none"] = 403;
    const auto files = open();
    EXPECT_EQ(files->sizeOf("none"), std::nullopt);
    EXPECT_THAT(files->whyNone(), AllOf(HasSubstr("/a/none"), HasSubstr("403")));
    EXPECT_EQ(read(*files, "file", 0, 5), "hello");
    EXPECT_EQ(read(*files, "shard", 0, 1).size(), 1u);
    server.statuses["/a/other"] = 403;
    EXPECT_EQ(files->sizeOf("other"), std::nullopt);
    // What gave the right has ended.
    server.statuses = {{"/a/file", 403}, {"/a/shard", 403}, {"/a/third", 403}};
    EXPECT_THAT(refusalOf([&] { files->sizeOf("third"); }), AllOf(HasSubstr("/a/third"), HasSubstr("403")));
    EXPECT_THAT(refusalOf([&] { read(*files, "shard", kRemoteBlockBytes, 9); }), HasSubstr("403"));
}

TEST_F(Remote, VersionsAreThoseOfNow) {
    writeBytes(served / "a" / "file", "first");
    const auto files = open();
    const std::string before = files->versionOf("file");
    EXPECT_EQ(files->versionOf("file"), before);
    EXPECT_EQ(files->versionOf("none"), "");
    writeBytes(served / "a" / "file", "other");
    EXPECT_NE(files->versionOf("file"), before);
    EXPECT_EQ(open()->versionOf("file"), open()->versionOf("file"));
    server.hasVersions = false;
    EXPECT_NE(open()->versionOf("file"), open()->versionOf("file")) << "no run knows it from another";
    const std::string address = server.address("a");
    const auto identityOf = [&](const std::string& with) {
        return openRemoteFiles(with, options)->identity();
    };
    EXPECT_NE(identityOf(address + "?sample=1"), identityOf(address + "?sample=2"));
    EXPECT_EQ(identityOf(address + "/#x"), identityOf(address));
    EXPECT_EQ(identityOf(address + "?secret").find("secret"), std::string::npos);
}

// Servers without tags say "not modified" of any file that is not newer than the known one.
TEST_F(Remote, AnOlderFileIsAnother) {
    server.hasTags = false;
    writeBytes(served / "a" / "file", "first");
    EXPECT_EQ(read(*open(), "file", 0, 5), "first");
    writeBytes(served / "a" / "file", "other");
    fs::last_write_time(served / "a" / "file", fs::file_time_type::clock::now() - std::chrono::hours(48));
    EXPECT_EQ(read(*open(), "file", 0, 5), "other");
}

TEST_F(Remote, OneFailureIsOneForAll) {
    writeBytes(served / "a" / "file", "hello");
    server.statuses["/a/file"] = 503;
    const auto files = open();
    EXPECT_THROW(files->sizeOf("file"), OutOfReach);
    const std::size_t asked = server.asked().size();
    for (int i = 0; i < 100; ++i)
        EXPECT_THROW(files->sizeOf("file"), OutOfReach);
    EXPECT_EQ(server.asked().size(), asked);
}

TEST_F(Remote, WhatIsToldAheadEndsWithItsFiles) {
    writeBytes(served / "a" / "file", randomBytes(200 * kRemoteBlockBytes));
    server.delay = std::chrono::milliseconds(20);
    {
        const auto files = open();
        std::vector<RemoteRange> ranges;
        for (std::uint64_t block = 0; block < 200; ++block)
            ranges.push_back({"file", block * kRemoteBlockBytes, 1});
        files->willRead(ranges);
    }
    EXPECT_LT(server.asked().size(), 100u);
}

TEST_F(Remote, LongerAnswersAreCut) {
    const std::string bytes = randomBytes(3 * kRemoteBlockBytes + 5);
    writeBytes(served / "a" / "file", bytes);
    server.isGenerous = true;
    EXPECT_EQ(read(*open(), "file", 0, bytes.size()), bytes);
    EXPECT_EQ(open()->counters().retries, 0u);
}

TEST_F(Remote, RedirectsAreFollowedAndBucketsAreFolders) {
    writeBytes(served / "bucket" / "deep" / "file", "found");
    server.redirects["/a/file"] = "/bucket/deep/file";
    EXPECT_EQ(read(*open(), "file", 0, 5), "found");
    ::setenv("AWS_ENDPOINT_URL", server.address().c_str(), 1);
    EXPECT_EQ(read(*openRemoteFiles("s3://bucket/deep", options), "file", 0, 5), "found");
    ::unsetenv("AWS_ENDPOINT_URL");
    EXPECT_THAT(refusalOf([&] { openRemoteFiles("s3:///deep", options); }), HasSubstr("host"));
    server.redirects["/a/round"] = "/a/round";
    EXPECT_THAT(refusalOf([&] { open()->sizeOf("round"); }), HasSubstr("redirects"));
}

TEST_F(Remote, AStoreBehindAnAddressIsTheStore) {
    HashSource source(plainInfo({150, 90, 70}, ValueType::i16));
    const fs::path store = served / "torso.zarr";
    import(store, source);
    HttpServer& stores = server;
    std::mutex mutex;
    std::mt19937 random(9);
    stores.fault = [&](int, const AskedOf&) {
        const std::lock_guard lock(mutex);
        return random() % 5 == 0 ? Fault::unavailable : Fault::none;
    };
    const std::string address = stores.address("torso.zarr");
    EXPECT_THROW(StoreReader(address, *std::make_unique<MemoryBudget>("RAM", "--ram", 1 << 28)), InputError)
        << "no one made it reachable";
    makeReachable(address, openRemoteFiles(address, options));
    EXPECT_TRUE(isStore(address));
    EXPECT_FALSE(isStore(address + "/0"));
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 28);
    const StoreReader here(store, ram), there(address, ram);
    EXPECT_EQ(there.contentHash(), here.contentHash());
    for (int level = 0; level < kLevelCount; ++level) {
        const glm::ivec3 grid = chunkGrid(here.info().extentVoxels, level);
        parallelFor(cellCount(grid), 8, [&](std::size_t i) {
            const glm::ivec3 at = gridPosition(i, grid);
            std::vector<std::byte> a(here.chunkBytes()), b(here.chunkBytes());
            here.readChunk({level, at.x, at.y, at.z}, a);
            there.readChunk({level, at.x, at.y, at.z}, b);
            EXPECT_TRUE(std::memcmp(a.data(), b.data(), a.size()) == 0) << level << " " << i;
        });
    }
    const StoreReader* const both[] = {&here, &there};
    EXPECT_GT(fetchedFor(both)->requests, 0u);
    EXPECT_FALSE(fetchedFor(std::span(both).first(1)));
}

// A first picture needs neither the statistics of cells nor the rays of bricks.
TEST_F(Remote, CoarseStatisticsAreFewBytes) {
    HashSource source(plainInfo({150, 90, 70}, ValueType::i16));
    import(served / "torso.zarr", source);
    const std::string address = server.address("torso.zarr");
    makeReachable(address, openRemoteFiles(address, options));
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 28);
    const StoreReader here(served / "torso.zarr", ram), there(address, ram);
    const auto coarse = loadCoarseStatistics(there, ram, 2);
    ASSERT_TRUE(coarse);
    EXPECT_EQ(coarse->wideMin, loadStatistics(here, ram, 2).wideMin);
    std::size_t ofBricks = 0;
    for (const AskedOf& one : server.asked()) {
        EXPECT_THAT(one.target, Not(::testing::AnyOf(HasSubstr("cell_"), HasSubstr("rays"))));
        ofBricks += one.target.find("brick_") != std::string::npos;
    }
    EXPECT_EQ(ofBricks, 4u);
}

// The address itself may be a file, with a query of its own.
TEST_F(Remote, AnAddressIsAFile) {
    const std::string bytes = randomBytes(3 * kRemoteBlockBytes + 77);
    writeBytes(served / "a/mesh.ply", bytes);
    const auto files = open("a/mesh.ply?token=x");
    ASSERT_EQ(files->sizeOf(""), bytes.size());
    EXPECT_EQ(read(*files, "", kRemoteBlockBytes - 5, 2 * kRemoteBlockBytes),
              bytes.substr(kRemoteBlockBytes - 5, 2 * kRemoteBlockBytes));
    EXPECT_NE(files->versionOf(""), "");
    EXPECT_FALSE(files->sizeOf("deep"));
    for (const AskedOf& one : server.asked())
        EXPECT_THAT(one.target, ::testing::AnyOf("/a/mesh.ply?token=x", "/a/mesh.ply/deep?token=x"));
    EXPECT_THAT(refusalOf([&] { read(*files, "", bytes.size(), 1); }),
                ::testing::AllOf(HasSubstr("a/mesh.ply: "), Not(HasSubstr("token"))));
}

} // namespace
} // namespace tessera::test
