// tests/bricking/import/files/raw_test.cpp: raw files with a sidecar: offset, byte order, units, and every
// lie refused.
#include "tests/support/import_test_tools.h"

#include <gmock/gmock.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

class RawFile : public ::testing::Test {
  protected:
    /// The sidecar with `extra` members appended and "type", "extent", "spacing" as given.
    void write(const std::string& extra = "", const std::string& extent = "[3,2,1]",
               const std::string& spacing = "[1,1,1]", const std::string& type = "\"int16\"") {
        writeFile(folder / "a.json", "{\"data\":\"a.raw\",\"extent\":" + extent + ",\"spacing\":" + spacing +
                                         ",\"type\":" + type + extra + "}");
    }
    std::string refused() { return refusalOfOpening(folder / "a.json"); }
    ScratchFolder folder;
};

TEST_F(RawFile, OffsetEndianRescaleAndUnit) {
    writeFile(folder / "a.raw", "HEAD" + voxelBytes<std::int16_t>({1, -2, 3, 4, 5, 600}, true));
    write(R"(,"offset":4,"endian":"big","rescaleSlope":2,"rescaleIntercept":-24,"unit":"HU")");
    const auto source = openSource(folder / "a.json", {});
    EXPECT_EQ(readAll<std::int16_t>(*source), (std::vector<std::int16_t>{1, -2, 3, 4, 5, 600}));
    EXPECT_EQ(source->info().rescaleSlope, 2);
    EXPECT_EQ(source->info().rescaleIntercept, -24);
    EXPECT_EQ(source->info().unit, "HU");
    EXPECT_EQ(source->info().fillStored, -500); // -1024 HU
}

// Air fills what lies beyond where the type has a number for it.
TEST_F(RawFile, TheFillIsAirWhereTheTypeHoldsIt) {
    writeFile(folder / "a.raw", std::string(6, '\0'));
    for (const auto& [intercept, fill] :
         std::vector<std::pair<int, int>>{{-1024, 0}, {-1279, 255}, {-1280, 0}}) {
        write(",\"unit\":\"HU\",\"rescaleIntercept\":" + std::to_string(intercept), "[3,2,1]", "[1,1,1]",
              "\"uint8\"");
        EXPECT_EQ(openSource(folder / "a.json", {})->info().fillStored, fill) << intercept;
    }
}

TEST_F(RawFile, LyingSidecarsAreRefused) {
    writeFile(folder / "a.raw", std::string(12, '\0'));
    write();
    EXPECT_NO_THROW(openSource(folder / "a.json", {}));
    const auto expectRefusal = [this](const char* what) {
        const std::string message = refused();
        EXPECT_THAT(message, HasSubstr("a.json"));
        EXPECT_THAT(message, HasSubstr(what));
    };
    write("", "[3,2,2]"), expectRefusal("24 bytes");
    write("", "[2,2,1]"), expectRefusal("8 bytes");
    write("", "[2000000000,2000000000,2000000000]"), expectRefusal("2^62");
    write("", "[0,2,1]"), expectRefusal("extent");
    write("", "[3,2]"), expectRefusal("extent");
    write("", "[3.5,2,1]"), expectRefusal("extent");
    write("", "[3,2,1]", "[1,0,1]"), expectRefusal("spacing");
    write("", "[3,2,1]", "[1,-1,1]"), expectRefusal("spacing");
    write("", "[3,2,1]", "[1,1e400,1]"), expectRefusal("a.json");
    write("", "[3,2,1]", "[1,1,1]", "\"int12\""), expectRefusal("type");
    write(R"(,"colour":1)"), expectRefusal("\"colour\"");
    write(R"(,"offset":-1)"), expectRefusal("offset");
    write(R"(,"offset":18446744073709551615)"), expectRefusal("offset");
    write(R"(,"direction":[1,0,0,0,1,0,0,0,2])"), expectRefusal("direction");
    write(R"(,"direction":[1,1,0,0,0,0,0,0,1])"), expectRefusal("singular");
    write(R"(,"rescaleSlope":0)"), expectRefusal("slope");
    write(R"(,"endian":"middle")"), expectRefusal("endian");
    writeFile(folder / "a.json", "{"), expectRefusal("JSON");
    writeFile(folder / "a.json", std::string(200, '[')), expectRefusal("JSON");
    writeFile(folder / "a.json", "[]"), expectRefusal("object");
    writeFile(folder / "a.json", R"({"data":"../a.raw","extent":[3,2,1],"spacing":[1,1,1],"type":"int16"})");
    expectRefusal("inside the sidecar's folder");
    writeFile(folder / "a.json", R"({"data":"none.raw","extent":[3,2,1],"spacing":[1,1,1],"type":"int16"})");
    EXPECT_THAT(refused(), HasSubstr("none.raw"));
}

} // namespace
} // namespace tessera::test
