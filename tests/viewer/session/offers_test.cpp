// tests/viewer/session/offers_test.cpp: a folder with several volumes: they are offered, each with a small
// picture, and the one that is chosen is opened.
#include "core/base/program_folders.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/folders.h"
#include "tests/support/looker.h"
#include "viewer/session/volume_offers.h"

#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// Slices of 12 x 10 pixels, with a bright rectangle.
void writeSeries(const fs::path& folder, const std::string& number, int slices,
                 const std::function<void(DicomImage&, int)>& change = {}) {
    fs::create_directories(folder);
    for (int n = 0; n < slices; ++n) {
        DicomImage image;
        image.columns = 12;
        image.rows = 10;
        image.spacingX = image.spacingY = 1;
        image.series = number;
        image.pixels.assign(120, 1024);
        for (int y = 3; y < 7; ++y)
            for (int x = 4; x < 10; ++x)
                image.pixels[static_cast<std::size_t>(12 * y + x)] = static_cast<std::uint16_t>(2000 + n);
        image.position = glm::dvec3(0, 0, 2 * n);
        if (change)
            change(image, n);
        writeDicom(folder / (number + "-" + std::to_string(n)), image);
    }
}

class Offers : public ::testing::Test {
  protected:
    void SetUp() override {
#if !TESSERA_WITH_IMPORT
        GTEST_SKIP() << "built without importers";
#endif
    }
    std::shared_ptr<const VolumeOffers> offered(Looker& looker, const fs::path& path) {
        looker.viewing->open(path, kPicture);
        EXPECT_TRUE(looker.comesTo([&] {
            return looker.viewing->offers() || looker.viewing->state().kind == ViewingState::Kind::failed;
        }));
        return looker.viewing->offers();
    }
    ScratchFolder folder_;
};

TEST_F(Offers, AreListedWithPicturesAndOpenedByChoice) {
    writeSeries(folder_ / "scan", "1", 4);
    writeSeries(folder_ / "scan", "2", 7);
    writeSeries(folder_ / "scan", "3", 1, [](DicomImage& image, int) {
        image.modality = "SR";
        image.withPixels = false;
        image.storageClass = "1.2.840.10008.5.1.4.1.1.88.67";
    });
    Looker looker(false);
    const auto offers = offered(looker, folder_ / "scan");
    ASSERT_TRUE(offers);
    EXPECT_EQ(looker.viewing->state().kind, ViewingState::Kind::choosing);
    ASSERT_EQ(offers->offers.size(), 2u) << "a report is no volume";
    EXPECT_THAT(offers->offers[1].title, HasSubstr("series 2, CT"));
    EXPECT_THAT(offers->offers[1].about, HasSubstr("7 slices"));
    EXPECT_EQ(offers->offers[1].problem, "");
    ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->thumbnail(0) && looker.viewing->thumbnail(1); }));
    const auto thumbnail = looker.viewing->thumbnail(1);
    ASSERT_EQ(thumbnail->display.size(),
              static_cast<std::size_t>(thumbnail->size.x) * static_cast<std::size_t>(thumbnail->size.y));
    const auto at = [&](double x, double y) {
        return thumbnail->display[static_cast<std::size_t>(y * thumbnail->size.y) *
                                      static_cast<std::size_t>(thumbnail->size.x) +
                                  static_cast<std::size_t>(x * thumbnail->size.x)] &
               0xff;
    };
    EXPECT_NEAR(static_cast<double>(thumbnail->size.x) / thumbnail->size.y, 1.2, 0.02);
    EXPECT_EQ(at(0.1, 0.1), 0u) << "air";
    EXPECT_EQ(at(0.6, 0.5), 255u) << "the rectangle";

    looker.viewing->open(offers->offers[1].path, kPicture, offers->offers[1].pick);
    ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->volume() != nullptr; }));
    EXPECT_EQ(looker.viewing->volume()->info.extentVoxels.z, 7);
    EXPECT_EQ(looker.viewing->offers(), nullptr);
}

// The words of an offer: number, kind, slices, voxels, and why it cannot be opened.
TEST_F(Offers, SayWhatTheyAre) {
    writeSeries(folder_ / "scan", "1", 1);
    writeSeries(folder_ / "scan", "2", 7, [](DicomImage& image, int n) {
        image.position = glm::dvec3(0, 0, n == 6 ? 15 : 2 * n); // uneven
    });
    const auto offers = volumeOffers(folder_ / "scan", {});
    ASSERT_TRUE(offers);
    ASSERT_EQ(offers->offers.size(), 2u);
    EXPECT_EQ(offers->path, folder_ / "scan");
    const VolumeOffer &one = offers->offers[0], &uneven = offers->offers[1];
    EXPECT_EQ(one.title, "series 1, CT");
    EXPECT_EQ(one.about.rfind("1 slice", 0), 0u) << one.about;
    EXPECT_EQ(one.about.find("slices"), std::string::npos) << one.about;
    EXPECT_EQ(one.pick.series, 1);
    EXPECT_FALSE(one.pick.resampleZ || one.pick.allowMissing);
    EXPECT_EQ(uneven.about.rfind("7 slices", 0), 0u) << uneven.about;
    EXPECT_THAT(uneven.about, HasSubstr("uneven slices, which are interpolated"));
    EXPECT_TRUE(uneven.pick.resampleZ);
    EXPECT_EQ(uneven.problem, "");
    EXPECT_EQ(uneven.path, folder_ / "scan");
    EXPECT_FALSE(asksForChoice(one.about + uneven.about));
}

// Of phases one is chosen; what is open stays while one chooses.
TEST_F(Offers, PhasesAreOfferedOverWhatIsOpen) {
    for (int phase = 0; phase < 2; ++phase) {
        writeSeries(folder_ / "part", "1", 5,
                    [&](DicomImage& image, int) { image.cardiacPercent = 10 + 60 * phase; });
        fs::create_directories(folder_ / "scan");
        for (const auto& file : fs::directory_iterator(folder_ / "part"))
            fs::rename(file.path(),
                       folder_ / "scan" / (std::to_string(phase) + file.path().filename().string()));
    }
    Looker looker(false);
    looker.opened(storePath("torso"));
    const auto offers = offered(looker, folder_ / "scan");
    ASSERT_TRUE(offers);
    ASSERT_EQ(offers->offers.size(), 1u);
    EXPECT_EQ(offers->offers[0].phases.size(), 2u);
    EXPECT_THAT(offers->offers[0].about, ::testing::Not(HasSubstr("--")));
    EXPECT_EQ(looker.viewing->state().kind, ViewingState::Kind::open);
    EXPECT_EQ(looker.viewing->volume()->path, storePath("torso"));
    EXPECT_TRUE(looker.comesTo([&] { return looker.viewing->thumbnail(0) != nullptr; }));
    VolumePick pick = offers->offers[0].pick;
    pick.phase = 2;
    looker.viewing->open(offers->offers[0].path, kPicture, pick);
    ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->volume()->path == folder_ / "scan"; }));
    EXPECT_EQ(looker.viewing->volume()->info.extentVoxels.z, 5);
}

// One volume is opened at once, and where nothing can be opened nothing is offered.
TEST_F(Offers, NothingIsOfferedWhereNothingIsToBeChosen) {
    writeSeries(folder_ / "one", "1", 4);
    Looker looker(false);
    looker.opened(folder_ / "one");
    EXPECT_EQ(looker.viewing->offers(), nullptr);
    fs::create_directories(folder_ / "none");
    std::ofstream(folder_ / "none/notes.txt") << "notes";
    EXPECT_EQ(volumeOffers(folder_ / "none", {}), nullptr);
}

} // namespace
} // namespace tessera::test
