// tests/bricking/store/store_damage_test.cpp: a store that is damaged is refused by name, or mended where it
// can be.
#include "tests/support/bricking_store_tools.h"

#include "bricking/statistics/statistics.h"
#include "bricking/store/checked_json.h"

#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A store of 33x47x65 and a way to read all of it: levels, then statistics, which are rebuilt where damaged.
class DamagedStore : public testing::Test {
  protected:
    void SetUp() override {
        HashSource source(plainInfo({33, 47, 65}, ValueType::u8));
        import(path, source);
        whole = readAll();
    }
    std::vector<double> readAll() const {
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(path, ram);
        std::vector<double> all;
        for (int level = 0; level < kLevelCount; ++level) {
            const auto values = readLevel(store, level);
            all.insert(all.end(), values.begin(), values.end());
        }
        const Statistics statistics = loadStatistics(store, ram, 1);
        for (const std::vector<float>* values :
             {&statistics.cellMin, &statistics.cellMax, &statistics.brickMean, &statistics.brickMin,
              &statistics.brickMax, &statistics.wideMin, &statistics.wideMax})
            all.insert(all.end(), values->begin(), values->end());
        for (const std::uint64_t count : statistics.histogram)
            all.push_back(static_cast<double>(count));
        return all;
    }
    void flip(const fs::path& file, std::size_t bit) const {
        std::string text = fileText(path / file);
        text[bit / 8] = static_cast<char>(text[bit / 8] ^ (1 << (bit % 8)));
        setFileText(path / file, text);
    }
    ScratchFolder scratch;
    fs::path path = scratch / "v.zarr";
    std::vector<double> whole;
};

TEST_F(DamagedStore, AFlippedBitInAPayloadIsRefusedAndTheChunkNamed) {
    // Index of 0/c/0/0/0: chunks are 2 x 2 x 3, so entry 1 is chunk (1,0,0).
    const std::string text = fileText(path / "0/c/0/0/0");
    std::uint64_t offset = 0, bytes = 0;
    std::memcpy(&offset, text.data() + text.size() - 4 - 16 * 12 + 16, 8);
    std::memcpy(&bytes, text.data() + text.size() - 4 - 16 * 12 + 24, 8);
    flip("0/c/0/0/0", 8 * (offset + bytes / 2) + 3);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(path, ram);
    std::vector<std::byte> chunk(store.chunkBytes());
    EXPECT_THAT(
        [&] {
            store.readChunk({0, 1, 0, 0}, chunk);
        },
        ThrowsMessage<InputError>(AllOf(HasSubstr("0/c/0/0/0"), HasSubstr("level 0 chunk (1,0,0)"),
                                        HasSubstr("expected checksum"))));
    EXPECT_NO_THROW(store.readChunk({0, 0, 0, 0}, chunk)) << "undamaged chunks stay readable";
}

TEST_F(DamagedStore, EverySingleFlippedBitInAShardIsRefused) {
    std::mt19937 random(20);
    for (const char* file : {"0/c/0/0/0", "1/c/0/0/0", "4/c/0/0/0", "5/c/0/0/0"}) {
        const std::string text = fileText(path / file);
        const std::size_t index = text.size() < 260 ? 20 : 16 * 12 + 4; // bytes; every bit of a few entries
        for (int i = 0; i < 20; ++i) {
            const std::size_t bit =
                i < 10 ? random() % (8 * text.size())
                       : 8 * (text.size() - index) + random() % (8 * std::min(index, text.size()));
            flip(file, bit);
            EXPECT_THROW(readAll(), InputError) << file << " bit " << bit;
            setFileText(path / file, text);
        }
    }
    EXPECT_TRUE(readAll() == whole);
}

TEST_F(DamagedStore, AFlippedBitInMetadataIsRefusedOrWithoutEffect) {
    std::mt19937 random(21);
    int refused = 0;
    for (const char* file : {"zarr.json", "0/zarr.json", "3/zarr.json"}) {
        const std::string text = fileText(path / file);
        for (int i = 0; i < 50; ++i) {
            const std::size_t bit = random() % (8 * text.size());
            flip(file, bit);
            MemoryBudget ram("RAM", "--ram", kPlenty);
            try {
                EXPECT_EQ(StoreReader(path, ram).info().patientFromVoxel,
                          plainInfo({1, 1, 1}, ValueType::u8).patientFromVoxel);
            } catch (const InputError& problem) {
                EXPECT_THAT(problem.what(), HasSubstr(file));
                ++refused;
            }
            setFileText(path / file, text);
        }
    }
    EXPECT_GT(refused, 120); // white space may change into other white space
}

TEST_F(DamagedStore, DamagedStatisticsAreRebuilt) {
    std::mt19937 random(22);
    for (const char* file : {"stats/zarr.json", "stats/cell_min/c/0/0/0", "stats/cell_max/zarr.json"}) {
        const std::string text = fileText(path / file);
        for (int i = 0; i < 10; ++i) {
            flip(file, random() % (8 * text.size()));
            EXPECT_TRUE(readAll() == whole) << file;
            setFileText(path / file, text);
        }
        fs::remove(path / file);
        EXPECT_TRUE(readAll() == whole) << file;
        setFileText(path / file, text);
    }
    // Whole chunks, of another array: only the sum over each array tells.
    for (const auto& [to, from] :
         {std::pair("cell_min", "cell_max"), std::pair("cell_max", "cell_min"),
          std::pair("brick_min", "brick_max"), std::pair("brick_max", "brick_min")}) {
        const fs::path file = path / "stats" / to / "c/0/0/0";
        const std::string text = fileText(file);
        setFileText(file, fileText(path / "stats" / from / "c/0/0/0"));
        EXPECT_TRUE(readAll() == whole) << to;
        setFileText(file, text);
    }
    fs::remove_all(path / "stats");
    EXPECT_TRUE(readAll() == whole);
}

TEST_F(DamagedStore, ATruncatedFileIsRefused) {
    std::mt19937 random(23);
    for (const char* file : {"0/c/0/0/0", "2/c/0/0/0", "zarr.json", "0/zarr.json"}) {
        const std::string text = fileText(path / file);
        const std::size_t n = text.size();
        std::vector<std::size_t> lengths = {0, 1, n / 2, n - 1, n - 2, n - 4, n - 5, n - 20};
        for (int i = 0; i < 8; ++i)
            lengths.push_back(random() % n);
        for (const std::size_t length : lengths) {
            if (text.substr(length) == "\n")
                continue; // the last line end carries nothing
            setFileText(path / file, text.substr(0, length));
            EXPECT_THAT([&] { readAll(); }, ThrowsMessage<InputError>(HasSubstr(file))) << length;
        }
        setFileText(path / file, text);
    }
}

TEST_F(DamagedStore, ALostShardIsNotTakenForFill) {
    fs::remove(path / "1/c/0/0/0");
    EXPECT_THAT([&] { readAll(); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("1/c/0/0/0"), HasSubstr("level 1 chunk (0,0,0)"))));
}

TEST_F(DamagedStore, AShardOfAnotherStoreIsRefused) {
    // Whole and with right checksums, but not the one that was written here.
    HashSource source(plainInfo({33, 47, 65}, ValueType::u8),
                      [](int x, int y, int z) { return (x + y * z) % 200; });
    import(scratch / "other.zarr", source);
    fs::copy_file(scratch / "other.zarr/0/c/0/0/0", path / "0/c/0/0/0", fs::copy_options::overwrite_existing);
    EXPECT_THAT([&] { readAll(); }, ThrowsMessage<InputError>(HasSubstr("another index")));
}

TEST_F(DamagedStore, LinksFifosAndMissingPartsAreRefused) {
    fs::rename(path / "0/c/0/0/0", scratch / "elsewhere");
    fs::create_symlink(scratch / "elsewhere", path / "0/c/0/0/0");
    EXPECT_THAT([&] { readAll(); }, ThrowsMessage<InputError>(HasSubstr("symbolic link")));
    fs::remove(path / "0/c/0/0/0");
    fs::create_directory(path / "0/c/0/0/0");
    EXPECT_THROW(readAll(), InputError);
    fs::remove(path / "3/zarr.json");
    EXPECT_THAT([&] { readAll(); }, ThrowsMessage<InputError>(HasSubstr("3/zarr.json")));
    MemoryBudget ram("RAM", "--ram", kPlenty);
    EXPECT_THROW(StoreReader(scratch / "nowhere.zarr", ram), InputError);
}

// Values that nothing else holds a copy of: what is shown would be another volume, sound in itself.
TEST_F(DamagedStore, AnEditedNumberIsRefused) {
    const std::string text = fileText(path / "zarr.json");
    for (const char* key : {"\"intercept\": ", "\"slope\": ", "\"tubeVoltageKv\": "}) {
        const std::size_t at = text.find(key);
        ASSERT_NE(at, std::string::npos) << key;
        std::string edited = text;
        edited[at + std::string(key).size()] = '3';
        ASSERT_NE(edited, text);
        setFileText(path / "zarr.json", edited);
        EXPECT_THAT([&] { readAll(); },
                    ThrowsMessage<InputError>(AllOf(HasSubstr("zarr.json"), HasSubstr("edited"))))
            << key;
    }
}

// Sealed again, as no damage is: a store that someone made.
TEST_F(DamagedStore, AFrameOfReferenceThatIsNoUidIsRefused) {
    const std::string text = fileText(path / "zarr.json");
    const auto withFrame = [&](const Json& frame) {
        Json document = Json::parse(text);
        document["attributes"]["tessera"]["frameOfReference"] = frame;
        seal(document);
        setFileText(path / "zarr.json", document.dump());
    };
    for (const Json& frame :
         {Json(7), Json(nullptr), Json::array({"1.2"}), Json::object(), Json(""), Json("1.2\x1b[2J"),
          Json("1.2 "), Json("../../etc"), Json(std::string(1'000'000, '1')), Json(std::string(65, '1'))}) {
        withFrame(frame);
        EXPECT_THAT([&] { readAll(); },
                    ThrowsMessage<InputError>(
                        AllOf(HasSubstr("zarr.json: expected /attributes/tessera/frameOfReference to be a "),
                              testing::Not(HasSubstr("\x1b")),
                              testing::SizeIs(testing::Lt(400u + path.string().size())))))
            << frame.dump().substr(0, 40);
    }
    withFrame("1.2.3");
    EXPECT_NO_THROW(readAll());
}

TEST_F(DamagedStore, AnEditedLevelIsRefusedWithTheKey) {
    std::string text = fileText(path / "2/zarr.json");
    text.replace(text.find("bitshuffle"), 10, "noshuffle");
    setFileText(path / "2/zarr.json", text);
    EXPECT_THAT([&] { readAll(); },
                ThrowsMessage<InputError>(
                    AllOf(HasSubstr("2/zarr.json"), HasSubstr("/shuffle"), HasSubstr("noshuffle"))));
}

} // namespace
} // namespace tessera
