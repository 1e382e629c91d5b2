// tests/bricking/import/files/raw_test.cpp: raw files with a sidecar: offset, byte order, units, and every
// lie refused.
#include "tests/support/import_test_tools.h"

#include <cmath>
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

// What a sidecar need not say.
TEST_F(RawFile, DefaultsAreThoseOfAPlainVolume) {
    writeFile(folder / "a.raw", std::string(12, '\0'));
    write("", "[3,2,1]", "[0.5,0.75,1.25]");
    const auto source = openSource(folder / "a.json", {});
    const VolumeInfo& info = source->info();
    EXPECT_EQ(source->describe(), "raw int16 file with sidecar");
    EXPECT_EQ(info.spacingMm(), glm::dvec3(0.5, 0.75, 1.25));
    EXPECT_EQ(firstVoxelCentreMm(info), glm::dvec3(0));
    EXPECT_FALSE(info.orientationKnown);
    EXPECT_EQ(info.rescaleSlope, 1);
    EXPECT_EQ(info.rescaleIntercept, 0);
    EXPECT_EQ(info.unit, "");
    EXPECT_EQ(info.fillStored, 0);
    writeFile(folder / "a.raw", voxelBytes<std::int16_t>({1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(readAll<std::int16_t>(*openSource(folder / "a.json", {})),
              (std::vector<std::int16_t>{1, 2, 3, 4, 5, 6}));
    writeFile(folder / "a.raw", std::string(48, '\0'));
    write("", "[3,2,1]", "[1,1,1]", "\"float64\"");
    EXPECT_EQ(openSource(folder / "a.json", {})->describe(),
              "raw float64 file with sidecar, converted to float32");
}

// The last value of each key that is taken, and the first that is not.
TEST_F(RawFile, KeysUpToTheirLastValue) {
    writeFile(folder / "a.raw", std::string(12, '\0'));
    const auto taken = [&](const std::string& more) {
        write(more);
        EXPECT_NO_THROW(openSource(folder / "a.json", {})) << more;
    };
    taken(",\"unit\":\"" + std::string(16, 'x') + '"');
    write(",\"unit\":\"" + std::string(17, 'x') + '"');
    EXPECT_THAT(refused(), HasSubstr("at most 16 characters"));
    taken(R"(,"direction":[1,0,0, 0,1.0009,0, 0,0,0.9991])");
    for (const char* length : {"1.0015", "0.9985"}) {
        write(std::string(R"(,"direction":[1,0,0, 0,)") + length + ",0, 0,0,1]");
        EXPECT_THAT(refused(), HasSubstr("columns of length 1")) << length;
    }
    // A mebibyte of blanks around the keys is the last that a sidecar has.
    for (const std::size_t more : {0u, 1u}) {
        const std::string text = R"({"data":"a.raw","extent":[3,2,1],"spacing":[1,1,1],"type":"int16"})";
        writeFile(folder / "a.json", text + std::string((1u << 20) - text.size() + more, ' '));
        if (more == 0) {
            EXPECT_NO_THROW(openSource(folder / "a.json", {}));
        } else {
            EXPECT_THAT(refused(), HasSubstr("at most 1 MiB"));
        }
    }
    // Data of an absolute path, and the whole message of data that are not as long as said.
    writeFile(folder / "a.json", R"({"data":")" + (folder / "a.raw").string() +
                                     R"(","extent":[3,2,1],"spacing":[1,1,1],"type":"int16"})");
    EXPECT_NO_THROW(openSource(folder / "a.json", {}));
    for (const auto& [offset, found] : {std::pair(1, false), {0, true}, {13, false}}) {
        write(",\"offset\":" + std::to_string(offset));
        if (found) {
            EXPECT_NO_THROW(openSource(folder / "a.json", {}));
        } else {
            EXPECT_THAT(refused(), HasSubstr("12 bytes of voxels after an offset of " +
                                             std::to_string(offset) + ", as "));
        }
    }
}

// Values stay below 1e12, whatever the type has; of more than 24 bits a float has as many.
TEST_F(RawFile, SlopesByTheTypesLargestNumber) {
    const auto isTaken = [&](const char* type, std::size_t bytes, double slope, double intercept) {
        char text[96];
        std::snprintf(text, sizeof text, R"(,"rescaleSlope":%.12g,"rescaleIntercept":%.12g)", slope,
                      intercept);
        writeFile(folder / "a.raw", std::string(6 * bytes, '\0'));
        write(text, "[3,2,1]", "[1,1,1]", "\"" + std::string(type) + "\"");
        try {
            openSource(folder / "a.json", {});
            return true;
        } catch (const InputError&) {
            return false;
        }
    };
    for (const auto& [type, bytes, bits] :
         std::vector<std::tuple<const char*, std::size_t, int>>{{"int8", 1, 8},
                                                                {"uint16", 2, 16},
                                                                {"int32", 4, 24},
                                                                {"uint64", 8, 24},
                                                                {"float32", 4, 0},
                                                                {"float64", 8, 0}}) {
        const double most = std::ldexp(1e12, -bits);
        EXPECT_TRUE(isTaken(type, bytes, 0.999 * most, 0)) << type;
        EXPECT_FALSE(isTaken(type, bytes, 1.001 * most, 0)) << type;
        EXPECT_EQ(isTaken(type, bytes, 1e-6, 100), bits == 0) << type;
    }
}

// Air is -1024 HU, where a whole number of the type is.
TEST_F(RawFile, TheFillOfEveryType) {
    const auto fill = [&](const char* type, std::size_t bytes, const std::string& slope,
                          const std::string& intercept) {
        writeFile(folder / "a.raw", std::string(6 * bytes, '\0'));
        write(R"(,"unit":"HU","rescaleSlope":)" + slope + ",\"rescaleIntercept\":" + intercept, "[3,2,1]",
              "[1,1,1]", "\"" + std::string(type) + "\"");
        return openSource(folder / "a.json", {})->info().fillStored;
    };
    EXPECT_EQ(fill("int16", 2, "1", "0"), -1024);
    EXPECT_EQ(fill("int16", 2, "1", "31744"), -32768);
    EXPECT_EQ(fill("int16", 2, "1", "31745"), 0);
    EXPECT_EQ(fill("int16", 2, "1", "-33791"), 32767);
    EXPECT_EQ(fill("int16", 2, "1", "-33792"), 0);
    EXPECT_EQ(fill("int16", 2, "2", "-1"), 0) << "-511.5";
    EXPECT_EQ(fill("uint16", 2, "1", "-1024"), 0);
    EXPECT_EQ(fill("uint16", 2, "1", "-1023"), 0) << "-1";
    EXPECT_EQ(fill("uint16", 2, "1", "-66559"), 65535);
    EXPECT_EQ(fill("uint16", 2, "1", "-66560"), 0);
    EXPECT_EQ(fill("float32", 4, "2", "-1"), -511.5);
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
