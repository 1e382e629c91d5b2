// tests/bricking/analysis/table_mask_test.cpp: tables under patients that are formulas: what is hidden is
// table and never patient.
#include "bricking/analysis/body/body_box.h"
#include "bricking/analysis/body/table_mask.h"
#include "core/base/error.h"
#include "tests/support/lumen_tubes.h"
#include "tests/support/plain_body.h"
#include "tests/support/recorded_numbers.h"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <tuple>

namespace tessera::test {
namespace {

constexpr double kAir = -1000;

double ellipseAt(const glm::dvec3& p, const glm::dvec2& middle, const glm::dvec2& half) {
    return glm::length((glm::dvec2(p) - middle) / half);
}

/// On the back, y = 100 mm; 300 mm long.
struct Named {
    const char* name;
    Field hu;
};

double trunk(const glm::dvec3& p) {
    const bool lungs = std::min(ellipseAt(p, {-75, 0}, {60, 75}), ellipseAt(p, {75, 0}, {60, 75})) < 1;
    return ellipseAt(p, {0, 0}, {160, 100}) < 1 && !(lungs && p.z > 60) ? 40 : kAir;
}

const std::vector<Named>& patients() {
    static const std::vector<Named> all = {
        {"a trunk", trunk},
        {"arms on the table",
         [](const glm::dvec3& p) {
             const bool arms =
                 std::min(ellipseAt(p, {-205, 62}, {38, 38}), ellipseAt(p, {205, 62}, {38, 38})) < 1;
             return arms ? 40 : trunk(p);
         }},
        {"a hand with thin fingers on the table",
         [](const glm::dvec3& p) {
             const bool fingers = std::abs(p.z) < 60 && p.y > 85 && p.y < 100 && p.x > 165 && p.x < 240 &&
                                  std::fmod(p.z + 60, 30) < 15;
             return fingers ? 30 : trunk(p);
         }},
        {"legs, one of them raised",
         [](const glm::dvec3& p) {
             const bool legs = ellipseAt(p, {-80, 20}, {70, 70}) < 1 ||
                               ellipseAt(p, {90, 15 - 0.3 * (p.z + 150)}, {65, 65}) < 1;
             return legs ? 40 : kAir;
         }},
        {"a head with ears",
         [](const glm::dvec3& p) {
             const bool ears =
                 std::abs(p.z) < 30 && std::abs(p.y - 10) < 20 && std::abs(std::abs(p.x) - 84) < 6;
             return ears || glm::length((p - glm::dvec3(0, 0, -20)) / glm::dvec3(78, 100, 125)) < 1 ? 40
                                                                                                    : kAir;
         }},
    };
    return all;
}

struct NamedTable : Named {
    bool isOne = true;
};
const std::vector<NamedTable>& namedTables() {
    static const std::vector<NamedTable> all = {
        {{"none", [](const glm::dvec3&) { return kAir; }}, false},
        {{"a blanket, uneven",
          [](const glm::dvec3& p) {
              return p.y < -128 - 0.1 * p.z && p.y > -136 - 0.1 * p.z && std::abs(p.z) < 90 ? -150. : kAir;
          }},
         false},
        {{"a tube around the patient",
          [](const glm::dvec3& p) {
              return std::abs(ellipseAt(p, {0, 0}, {265, 135}) - 1) < 0.03 ? 100. : kAir;
          }},
         false},
        {{"a plate that touches", [](const glm::dvec3& p) { return p.y > 100 && p.y < 112 ? 100. : kAir; }}},
        {{"a trough that touches",
          [](const glm::dvec3& p) {
              const double r = ellipseAt(p, {0, -400}, {1, 1});
              return r > 500 && r < 512 && p.y > 60 && std::abs(p.x) < 150 ? 150. : kAir;
          }}},
        {{"plates and foam between",
          [](const glm::dvec3& p) {
              const bool plates = (p.y > 102 && p.y < 108) || (p.y > 138 && p.y < 146);
              return plates ? 300. : p.y > 108 && p.y < 138 ? -900. : kAir;
          }}},
        {{"a mattress that touches, and a board",
          [](const glm::dvec3& p) {
              return p.y > 120 && p.y < 132 ? 0. : p.y > 100 && p.y < 120 ? -700. : kAir;
          }}},
        {{"a board of light stuff alone",
          [](const glm::dvec3& p) { return p.y > 110 && p.y < 140 && std::abs(p.x) < 230 ? -600. : kAir; }}},
    };
    return all;
}

/// How a patient lies: p of the volume to p of the formulas.
struct Pose {
    const char* name;
    glm::dvec3 (*turned)(const glm::dvec3&);
};
const Pose kPoses[] = {{"on the back", [](const glm::dvec3& p) { return p; }},
                       {"on the front", [](const glm::dvec3& p) { return glm::dvec3(p.x, -p.y, p.z); }},
                       {"on the side", [](const glm::dvec3& p) { return glm::dvec3(-p.y, p.x, p.z); }}};

FoundTable found(const ChunkSource& source, MemoryBudget& ram, int threads = 2) {
    const FoundTable table = findTable(source, ram, threads);
    EXPECT_LE(ram.peakBytes(), tableMaskBytes(source.info()) + (table.mask ? ram.usedBytes() : 0));
    return table;
}

/// The same mask, litres and reason as the search voxel by voxel.
void expectThatOfThePlainWay(const FoundTable& it, const ChunkSource& source) {
    const PlainTable plain = plainTable(source, it.mask ? it.mask->level() : 0);
    EXPECT_EQ(it.why, plain.why);
    EXPECT_EQ(it.litres, plain.litres);
    ASSERT_EQ(it.mask != nullptr, plain.why.empty());
    const auto isHidden = [](std::uint8_t share, std::uint8_t hidden) { return share == (hidden ? 255 : 0); };
    EXPECT_TRUE(!it.mask || std::ranges::equal(it.mask->shares(), plain.hidden, isHidden));
}

/// Shares of voxels, of those that the formulas tell to be patient or table.
struct Hidden {
    double ofPatient = 0; // the largest share of any voxel
    double ofTable = 0;   // the mean share, two voxels and more from the patient
};
Hidden hidden(const Mask& mask, const VolumeInfo& info, const Field& patient, const Field& table) {
    Hidden out;
    std::vector<float> shares(info.voxelCount());
    mask.read(0, glm::ivec3(0), info.extentVoxels, shares);
    std::size_t ofTable = 0;
    const auto place = [&](const glm::ivec3& voxel) {
        return glm::dvec3(info.patientFromVoxel * glm::dvec4(glm::dvec3(voxel) + 0.5, 1));
    };
    for (std::size_t i = 0; i < shares.size(); ++i) {
        const glm::ivec3 voxel = gridPosition(i, info.extentVoxels);
        const double share = static_cast<double>(shares[i]);
        if (patient(place(voxel)) > -300)
            out.ofPatient = std::max(out.ofPatient, share);
        if (!(table(place(voxel)) > -950))
            continue;
        bool near = false;
        for (int n = 0; n < 125; ++n)
            near |=
                patient(place(voxel + gridPosition(static_cast<std::size_t>(n), glm::ivec3(5)) - 2)) > -300;
        if (!near) {
            out.ofTable += share;
            ++ofTable;
        }
    }
    out.ofTable /= static_cast<double>(std::max<std::size_t>(ofTable, 1));
    return out;
}

TEST(PatientTable, IsHiddenAndNothingOfThePatient) {
    for (const Pose& pose : kPoses)
        for (const Named& patient : patients())
            for (const NamedTable& table : namedTables()) {
                const bool onBack = &pose == kPoses, touches = table.isOne && &table < &namedTables()[5];
                if (!onBack && !touches)
                    continue;
                SCOPED_TRACE(std::string(patient.name) + " " + pose.name + ", " + table.name);
                const VolumeInfo info = onBack ? boxInfo({112, 64, 30}, {5, 5, 10}, {-280, -140, -150})
                                               : boxInfo({112, 112, 30}, {5, 5, 10}, {-280, -280, -150});
                const Field body = [&](const glm::dvec3& p) { return patient.hu(pose.turned(p)); };
                const Field under = [&](const glm::dvec3& p) { return table.hu(pose.turned(p)); };
                std::mt19937 random(7);
                std::normal_distribution<double> noise(0, 25);
                std::vector<std::int16_t> noises(1 << 16);
                for (std::int16_t& each : noises)
                    each = static_cast<std::int16_t>(std::clamp(noise(random), -90., 90.));
                const FieldChunks scan(info, [&](const glm::dvec3& p) {
                    const auto n = static_cast<std::size_t>(p.x * 7 + p.y * 1031 + p.z * 577 + 1e6);
                    return std::max(body(p), under(p)) + noises[n % noises.size()];
                });
                MemoryBudget ram("RAM", "--ram", 256u << 20);
                const FoundTable it = found(scan, ram);
                EXPECT_EQ(it.mask != nullptr, it.why.empty());
                EXPECT_EQ(it.mask != nullptr, table.isOne) << it.why;
                if (!it.mask)
                    continue;
                const Hidden share = hidden(*it.mask, info, body, under);
                EXPECT_EQ(share.ofPatient, 0);
                EXPECT_GT(share.ofTable, 0.75); // some are two voxels thick
            }
}

/// Level 1 of a field: means of eight voxels.
class CoarseChunks final : public ChunkSource {
  public:
    CoarseChunks(const VolumeInfo& info, Field field) : info_(info), field_(std::move(field)) {}
    const VolumeInfo& info() const override { return info_; }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        ASSERT_EQ(key.level, 1);
        auto* at = reinterpret_cast<std::int16_t*>(out.data());
        for (std::size_t i = 0; i < cellCount(glm::ivec3(kChunkExtent)); ++i) {
            const glm::ivec3 low = 2 * (glm::ivec3(key.i, key.j, key.k) * kChunkExtent +
                                        gridPosition(i, glm::ivec3(kChunkExtent)));
            double sum = 0;
            for (std::size_t n = 0; n < 8; ++n) {
                const glm::dvec3 voxel = glm::dvec3(low + gridPosition(n, glm::ivec3(2))) + 0.5;
                sum += field_(glm::dvec3(info_.patientFromVoxel * glm::dvec4(voxel, 1)));
            }
            *at++ = static_cast<std::int16_t>(std::lround(sum / 8));
        }
    }

  private:
    VolumeInfo info_;
    Field field_;
};

// Samples of the mask are twice as large as voxels here: skin lies within them.
TEST(PatientTable, OfACoarserMaskHidesNothingOfThePatientEither) {
    const VolumeInfo info = boxInfo({256, 144, 144}, {2.2, 2.2, 2.2}, {-281.6, -150, -158});
    // It ends, and ears lie on it.
    const Field holder = [](const glm::dvec3& p) {
        const double r = ellipseAt(p, {0, 0}, {90, 112});
        return r > 1 && r < 1.07 && p.y > -10 && p.z < 110 ? 800 : kAir;
    };
    for (const auto& [patient, table] :
         {std::pair<std::size_t, std::size_t>{1, 3}, {2, 6}, {3, 4}, {4, 5}, {4, 8}}) {
        const bool held = table == namedTables().size();
        const Field body = patients()[patient].hu, under = held ? holder : namedTables()[table].hu;
        SCOPED_TRACE(std::string(patients()[patient].name) + ", " +
                     (held ? "held" : namedTables()[table].name));
        const CoarseChunks scan(info, [&](const glm::dvec3& p) { return std::max(body(p), under(p)); });
        MemoryBudget ram("RAM", "--ram", 256u << 20);
        const FoundTable it = found(scan, ram);
        ASSERT_TRUE(it.mask) << it.why;
        EXPECT_EQ(it.mask->level(), 1);
        const Hidden share = hidden(*it.mask, info, body, under);
        // The corners of square fingers fill less than a quarter of a sample.
        EXPECT_LE(share.ofPatient, patient == 2 ? 0.25 : 0);
        EXPECT_GT(share.ofTable, held ? 0.4 : 0.75); // what is near ears stays
    }
}

// Walls go on from a holder's ground, around the head, and end before the scan does. Fingers with bones in
// them lie on a board, and a lug of it stands up beside the patient.
TEST(PatientTable, WallsOfHoldersAndCrumbsGoAndBonesStay) {
    const VolumeInfo info = boxInfo({256, 144, 144}, {2.2, 2.2, 2.2}, {-281.6, -150, -158});
    const Field head = patients()[4].hu;
    const Field holder = [](const glm::dvec3& p) {
        const double r = ellipseAt(p, {0, 0}, {92, 118});
        const bool ground = p.y > 60, wall = p.y > -85 && p.z < 40;
        return r > 1 && r < 1.06 && (ground || wall) ? 700 : kAir;
    };
    const Field hand = [](const glm::dvec3& p) {
        const double z = p.z - 24 * std::clamp(std::round(p.z / 24), -1., 1.),
                     x = p.x - std::clamp(p.x, 178., 242.);
        const double r = glm::length(glm::dvec3(x, p.y - 91, z));
        return r < 4 ? 700. : r < 8 ? 40. : trunk(p);
    };
    const Field board = [](const glm::dvec3& p) {
        const bool lug = p.x < -190 && p.x > -199 && p.y > 92 && p.z > 20 && p.z < 29;
        return (p.y > 100 && p.y < 112) || (lug && p.y < 112) ? 500. : kAir;
    };
    for (const auto& [body, under, least] : {std::tuple(head, holder, 0.95), std::tuple(hand, board, 0.9)}) {
        const CoarseChunks scan(info, [&](const glm::dvec3& p) { return std::max(body(p), under(p)); });
        MemoryBudget ram("RAM", "--ram", 256u << 20);
        const FoundTable it = found(scan, ram);
        ASSERT_TRUE(it.mask) << it.why;
        const Hidden share = hidden(*it.mask, info, body, under);
        EXPECT_EQ(share.ofPatient, 0);
        EXPECT_GT(share.ofTable, least);
        std::vector<float> lug(1);
        const glm::ivec3 at((-194.0 + 281.6) / 2.2, (94.0 + 150) / 2.2, (24.0 + 158) / 2.2);
        it.mask->read(0, at, glm::ivec3(1), lug);
        std::printf("lug %g %g table %g\n", (double)lug[0], under(glm::dvec3(-194, 94, 24)), share.ofTable);
    }
}

// A patient wider than the scan: lungs lie open at its sides. Behind walls that an opening removes nothing is
// hidden at all.
TEST(PatientTable, ANarrowFieldOfViewLaysNothingOpen) {
    const VolumeInfo info = boxInfo({44, 56, 30}, {5, 5, 10}, {-110, -130, -150});
    for (const double half : {70., 75., 85., 92.}) {
        const Field patient = [half](const glm::dvec3& p) {
            const bool lung =
                std::min(ellipseAt(p, {-75, 0}, {75, half}), ellipseAt(p, {75, 0}, {75, half})) < 1;
            return lung ? -850 : ellipseAt(p, {0, 0}, {160, 100}) < 1 ? 40 : kAir;
        };
        const Field table = namedTables()[3].hu;
        const FieldChunks scan(info, [&](const glm::dvec3& p) { return std::max(patient(p), table(p)); });
        MemoryBudget ram("RAM", "--ram", 256u << 20);
        const FoundTable it = found(scan, ram);
        EXPECT_TRUE(it.mask || half > 70) << half << ": " << it.why;
        if (!it.mask)
            continue;
        std::vector<float> shares(info.voxelCount());
        it.mask->read(0, glm::ivec3(0), info.extentVoxels, shares);
        for (std::size_t i = 0; i < shares.size(); ++i) {
            const glm::dvec3 voxel = glm::dvec3(gridPosition(i, info.extentVoxels)) + 0.5;
            const glm::dvec3 place(info.patientFromVoxel * glm::dvec4(voxel, 1));
            if (patient(place) > -900) {
                ASSERT_EQ(shares[i], 0) << half << ": " << place.x << " " << place.y << " " << place.z;
            }
        }
    }
}

/// Bodies, boards and lumps at random places, with noise, in grids that words of bits do not fit.
TEST(PatientTable, IsThatOfThePlainWay) {
    std::mt19937 random(11);
    int masks = 0;
    for (int n = 0; n < 24; ++n) {
        const auto between = [&](double low, double high) {
            return std::uniform_real_distribution<double>(low, high)(random);
        };
        const glm::ivec3 extent(static_cast<int>(between(40, 100)), static_cast<int>(between(30, 70)),
                                static_cast<int>(between(6, 30)));
        const glm::dvec3 spacing =
            n % 3 == 0 ? glm::dvec3(5) : glm::dvec3(between(3, 7), between(3, 7), between(4, 12));
        const VolumeInfo info = boxInfo(extent, spacing, -0.5 * glm::dvec3(extent) * spacing);
        const glm::dvec3 half = 0.5 * glm::dvec3(extent) * spacing;
        struct Lump {
            glm::dvec3 middle, half;
            double hu;
        };
        std::vector<Lump> lumps = {{{between(-20, 20), between(-20, 0), 0},
                                    {half.x * between(0.4, 0.8), half.y * between(0.4, 0.7), 900},
                                    40}};
        for (int i = 0; i < 12; ++i)
            lumps.push_back({{between(-1, 1) * half.x, between(-1, 1) * half.y, between(-1, 1) * half.z},
                             {between(5, 60), between(5, 60), between(5, 150)},
                             i % 3 == 0 ? -850. : between(-1100, 900)});
        const double board = half.y * between(0.6, 0.9), thick = between(4, 25), hu = between(-880, 400);
        const bool isOne = n % 5 != 0;
        const FieldChunks scan(info, [&](const glm::dvec3& p) {
            double value = isOne && p.y > board && p.y < board + thick ? hu : kAir;
            for (const Lump& each : lumps)
                if (glm::length((p - each.middle) / each.half) < 1)
                    value = each.hu;
            const auto at = static_cast<std::uint64_t>(p.x * 131 + p.y * 7919 + p.z * 1000003 + 1e9);
            return value + static_cast<double>(at * 0x9E3779B97F4A7C15u >> 57) - 64;
        });
        SCOPED_TRACE(n);
        MemoryBudget ram("RAM", "--ram", 256u << 20);
        const FoundTable it = found(scan, ram, n % 4 + 1);
        masks += it.mask != nullptr;
        expectThatOfThePlainWay(it, scan);
    }
    EXPECT_GE(masks, 6);
}

/// Values in HU, however they are stored.
TEST(PatientTable, RescaledValuesAreTheSame) {
    const VolumeInfo info = boxInfo({112, 64, 30}, {5, 5, 10}, {-280, -140, -150});
    VolumeInfo rescaled = info;
    rescaled.rescaleSlope = 0.5;
    rescaled.rescaleIntercept = -1024;
    const Field hu = [](const glm::dvec3& p) { return std::max(trunk(p), namedTables()[3].hu(p)); };
    const FieldChunks plain(info, hu),
        other(rescaled, [&](const glm::dvec3&p) { return 2 * (hu(p) + 1024); });
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    const BodyBox a = findBody(plain, ram), b = findBody(other, ram);
    EXPECT_EQ(a.low, b.low);
    EXPECT_EQ(a.high, b.high);
    EXPECT_EQ(a.litresLeftOut, b.litresLeftOut);
    const FoundTable c = findTable(plain, ram, 2), d = findTable(other, ram, 2);
    ASSERT_TRUE(c.mask && d.mask);
    EXPECT_EQ(c.litres, d.litres);
    EXPECT_TRUE(std::ranges::equal(c.mask->shares(), d.mask->shares()));
}

TEST(PatientTable, ThreadsChangeNothingAndLittleMemoryIsSaid) {
    const VolumeInfo info = boxInfo({112, 64, 30}, {5, 5, 10}, {-280, -140, -150});
    const FieldChunks scan(info,
                           [](const glm::dvec3& p) { return std::max(trunk(p), namedTables()[4].hu(p)); });
    MemoryBudget ram("RAM", "--ram", 256u << 20), few("RAM", "--ram", 1000);
    const FoundTable one = found(scan, ram, 1), four = found(scan, ram, 4);
    ASSERT_TRUE(one.mask && four.mask);
    EXPECT_THAT(std::vector<std::uint8_t>(one.mask->shares().begin(), one.mask->shares().end()),
                ::testing::ElementsAreArray(four.mask->shares()));
    EXPECT_NEAR(one.litres, 0.8, 0.4); // of a shell of 12 mm
    EXPECT_THROW(findTable(scan, few, 1), InputError);
}

/// Bodies, and what is hidden of tables, as they are recorded: sums over the hidden samples by their places.
/// Patients and tables that lie a little aside, so that nothing is symmetric.
TEST(PatientTable, IsThatOfTheRecord) {
    RecordedNumbers record("tests/bricking/analysis/recorded/tables.txt");
    const VolumeInfo info = boxInfo({109, 61, 33}, {5.2, 4.9, 9.3}, {-276, -143, -151});
    for (std::size_t n = 0; n < 5; ++n)
        for (const std::size_t of : {3 + n, 3 + (n + 2) % 5}) {
            const Named& patient = patients()[n];
            const NamedTable& table = namedTables()[of];
            const FieldChunks scan(info, [&](const glm::dvec3& p) {
                // a board ends at 120 mm, and is a little higher there
                const glm::dvec3 under = p + glm::dvec3(7, 0.01 * p.z, 0);
                return std::max(patient.hu(p - glm::dvec3(9, 3, 4)), p.z < 120 ? table.hu(under) : kAir);
            });
            MemoryBudget ram("RAM", "--ram", 256u << 20);
            const FoundTable it = findTable(scan, ram, 2);
            expectThatOfThePlainWay(it, scan);
            double hidden = 0, x = 0, y = 0, z = 0;
            for (std::size_t i = 0; it.mask && i < it.mask->shares().size(); ++i)
                if (it.mask->shares()[i]) {
                    const glm::ivec3 at = gridPosition(i, info.extentVoxels);
                    ++hidden;
                    x += at.x, y += at.y, z += at.z;
                }
            record.expect("table", {it.litres, hidden, x, y, z});
            const BodyBox box = findBody(scan, ram);
            record.expect("body", {box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z,
                                   box.litres, box.litresLeftOut});
        }
}

/// What is taken for body begins at -300 HU, boards of light stuff at -900 HU.
TEST(PatientTable, ThresholdsAreAsTheyAreSaid) {
    const VolumeInfo info = boxInfo({112, 64, 30}, {5, 5, 10}, {-280, -140, -150});
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    for (const double board : {-905.0, -900.0, -899.0, -500.0}) {
        const FieldChunks scan(info, [&](const glm::dvec3& p) {
            return std::max(trunk(p), p.y > 112 && p.y < 136 && std::abs(p.x) < 230 ? board : kAir);
        });
        EXPECT_EQ(findTable(scan, ram, 2).mask != nullptr, board > -900) << board;
    }
    for (const double tissue : {-301.0, -300.0, -299.0}) {
        const FieldChunks scan(info, [&](const glm::dvec3& p) { return trunk(p) > 0 ? tissue : kAir; });
        if (tissue > -300) {
            EXPECT_GT(findBody(scan, ram).litres, 5);
        } else {
            EXPECT_THROW(findBody(scan, ram), InputError);
        }
    }
    // shorter than 40 mm along the table is too little
    for (const int slices : {3, 4}) {
        const FieldChunks scan(
            boxInfo({112, 64, slices}, {5, 5, 10}, {-280, -140, -15}),
            [&](const glm::dvec3& p) { return std::max(trunk(p), namedTables()[3].hu(p)); });
        EXPECT_EQ(findTable(scan, ram, 2).why.find("shorter") != std::string::npos, slices < 4);
    }
}

/// A table takes four fifths of the volume's length at least.
TEST(PatientTable, ATableRunsAlongMostOfTheVolume) {
    const VolumeInfo info = boxInfo({112, 64, 30}, {5, 5, 10}, {-280, -140, -150});
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    for (const double end : {70.0, 80.0, 90.0, 100.0}) {
        const FieldChunks scan(info, [&](const glm::dvec3& p) {
            return std::max(trunk(p), p.y > 102 && p.y < 112 && p.z < end ? 100. : kAir);
        });
        EXPECT_EQ(findTable(scan, ram, 2).mask != nullptr, end >= 90) << end; // of 300 mm, from -150
    }
}

TEST(PatientTable, SaysWhyNothingIsHidden) {
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    const auto why = [&](const VolumeInfo& info, const Field& field) {
        return findTable(FieldChunks(info, field), ram, 2).why;
    };
    const VolumeInfo info = boxInfo({112, 64, 30}, {5, 5, 10}, {-280, -140, -150});
    EXPECT_THAT(why(info, [](const glm::dvec3&) { return kAir; }), ::testing::HasSubstr("no body"));
    EXPECT_THAT(why(info, trunk), ::testing::HasSubstr("nothing beside the body"));
    EXPECT_THAT(why(info, [](const glm::dvec3&) { return 40.; }), ::testing::HasSubstr("nothing beside"));
    EXPECT_THAT(why(info, [](const glm::dvec3& p) { return std::max(trunk(p), namedTables()[2].hu(p)); }),
                ::testing::HasSubstr("opposite sides"));
    EXPECT_THAT(why(boxInfo({112, 64, 3}, {5, 5, 10}, {-280, -140, -15}), trunk),
                ::testing::HasSubstr("shorter than 40 mm"));
}

/// Memory that is promised for the search of bodies and tables: of a level of few enough samples.
TEST(PatientTable, BytesAreThoseOfTheRecord) {
    RecordedNumbers record("tests/bricking/analysis/recorded/body_bytes.txt");
    for (const glm::ivec3& extent : {glm::ivec3(40, 33, 20),
                                     {128, 128, 128},
                                     {129, 128, 128},
                                     {256, 160, 128},
                                     {257, 160, 128},
                                     {512, 512, 400},
                                     {2048, 2048, 2048}}) {
        const VolumeInfo info = boxInfo(extent, glm::dvec3(1), glm::dvec3(0));
        record.expect("bytes",
                      {static_cast<double>(bodyBoxBytes(info)), static_cast<double>(tableMaskBytes(info))}, 0,
                      0.5);
    }
}

} // namespace
} // namespace tessera::test
