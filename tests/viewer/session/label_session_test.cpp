// tests/viewer/session/label_session_test.cpp: labels of an open volume: their list, the effect of every edit
// on pictures, picking, and scenes that are saved and opened again.
#include "core/base/program_folders.h"
#include "core/scene/preset.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/labelled_scan.h"
#include "tests/support/looker.h"
#include "viewer/session/view_geometry.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>

namespace tessera::test {
namespace {

using ::testing::ElementsAre;
namespace fs = std::filesystem;
using Numbers = std::vector<std::size_t>;

const std::vector<std::pair<std::uint32_t, std::string>> kFour = {
    {3, "liver"}, {12, "spleen"}, {40, "12"}, {7, "own"}, {90, "nowhere"}};

bool haveSameBits(const Image& a, const Image& b) {
    return a.size == b.size &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(glm::vec4)) == 0;
}

/// A window's session on the four columns.
class OnLabels {
  public:
    explicit OnLabels(bool stills = false) : looker(stills) {
        scene = looker.opened(scan.scene(kPicture));
        list = *looker.viewing->volume()->labels;
    }
    glm::ivec2 pixel(int column) const {
        const Camera& camera = std::get<Camera>(scene.camera);
        const glm::dvec3 mm(scan.info.patientFromVoxel * glm::dvec4(scan.column(column), 1));
        const double perMm = kPicture.y / 2.0 / camera.parallelScale;
        return {kPicture.x / 2.0 + (mm.x - camera.focalPoint.x) * perMm,
                kPicture.y / 2.0 - (mm.z - camera.focalPoint.z) * perMm};
    }
    Labels& labels() { return scene.volumes[0].labels; }
    Image draw() { return looker.wholeOf(looker.viewing->show(scene, false))->image; }
    glm::vec4 at(const Image& image, int column) const {
        const glm::ivec2 p = pixel(column);
        return image.pixels[static_cast<std::size_t>(p.y) * static_cast<std::size_t>(image.size.x) +
                            static_cast<std::size_t>(p.x)];
    }
    PickedPlace pick(int column) {
        const std::uint64_t question = looker.viewing->pick(glm::dvec2(pixel(column)) + 0.5);
        EXPECT_TRUE(looker.comesTo(
            [&] { return looker.viewing->picked() && looker.viewing->picked()->number >= question; }));
        return *looker.viewing->picked();
    }
    LabelledScan scan{kFour, 4};
    Looker looker;
    Scene scene;
    LabelList list;
};

// The three planes, and a slice in place of the volume: labels in their colours, as the scene has them.
TEST(LabelSession, PlanesAndSlicesShowLabels) {
    OnLabels on;
    const auto mmOf = [&](int column) {
        glm::dvec3 voxel = on.scan.column(column);
        voxel.y = 20.5;
        return glm::dvec3(on.scan.info.patientFromVoxel * glm::dvec4(voxel, 1));
    };
    const auto planesOf = [&](const Labels* labels) {
        SliceWish wish;
        wish.window = {400, 800};
        wish.placeMm = mmOf(1);
        wish.sizes = {glm::ivec2(120, 80), glm::ivec2(120, 80), glm::ivec2(80, 80)};
        if (labels)
            wish.labels = std::make_shared<const Labels>(*labels);
        on.looker.viewing->showSlices(wish);
        EXPECT_TRUE(on.looker.comesTo([&] {
            const auto shown = on.looker.viewing->slices();
            return shown && shown->wish == wish && shown->fine;
        }));
        return on.looker.viewing->slices();
    };
    const auto colourAt = [](const ShownSlice& plane, const glm::dvec3& mm) {
        const glm::ivec2 at(glm::floor(plane.frame.pictureFromPatient(mm)));
        const std::uint32_t code = plane.display[static_cast<std::size_t>(at.y * plane.frame.size.x + at.x)];
        return glm::ivec3(code & 255, code >> 8 & 255, code >> 16 & 255);
    };
    const auto isGrey = [](const glm::ivec3& c) { return c.r == c.g && c.g == c.b; };
    on.labels().each = {{.of = "12", .colour = glm::dvec3(0, 1, 0), .fill = 0.5}};
    const auto bare = planesOf(nullptr), labelled = planesOf(&on.labels());
    on.labels().hide = {"12"};
    const auto hidden = planesOf(&on.labels());
    for (std::size_t n = 0; n < 3; ++n) {
        const glm::ivec3 under = colourAt(bare->planes[n], mmOf(1)),
                         over = colourAt(labelled->planes[n], mmOf(1));
        EXPECT_TRUE(isGrey(under) && under.r > 100) << n;
        EXPECT_TRUE(over.r == over.b && over.r < under.r && over.g > under.g) << n;
        EXPECT_EQ(colourAt(hidden->planes[n], mmOf(1)), under) << n;
    }
    EXPECT_FALSE(isGrey(colourAt(hidden->planes[0], mmOf(0))));
    on.labels().hide.clear();
    on.scene.mode = Mode::slice;
    on.scene.slice.orientation = Orientation::coronal;
    on.scene.slice.positionMm = mmOf(1).y;
    on.scene.window = GreyWindow{400, 800};
    const glm::vec4 slice = on.at(on.draw(), 1);
    EXPECT_TRUE(slice.r == slice.b && slice.g > slice.r + 0.3f);
    EXPECT_EQ(on.looker.viewing->state().problem, "");
}

TEST(LabelSession, ListsTheLabelsOfTheOpenVolume) {
    OnLabels on;
    ASSERT_EQ(on.list.size(), 5u);
    const auto row = [&](std::size_t n) {
        const ListedLabel& label = on.list[n];
        return std::to_string(label.value) + " " + label.name + " " + label.group +
               (label.hasVoxels ? "" : " absent");
    };
    EXPECT_EQ(row(0), "3 liver organs");
    EXPECT_EQ(row(1), "7 own ");
    EXPECT_EQ(row(2), "12 spleen organs");
    EXPECT_EQ(row(3), "40 12 ");
    EXPECT_EQ(row(4), "90 nowhere  absent");
    Looker plain(false);
    plain.opened(on.scan.store);
    EXPECT_EQ(plain.viewing->volume()->labels, nullptr);
}

TEST(LabelSession, EditsShowInThePictureAndAreTakenBack) {
    OnLabels on;
    const Labels before = on.labels();
    const Image all = on.draw();
    const Numbers liver = {0}, spleen = {2}, named12 = {3}; // columns 0, 1, 2
    for (int column = 0; column < 4; ++column)
        EXPECT_GT(on.at(all, column).a, 0.99f) << column;

    on.labels() = withShown(on.list, before, liver, false);
    EXPECT_THAT(on.labels().hide, ElementsAre("3"));
    const Image hidden = on.draw();
    EXPECT_LT(on.at(hidden, 0).a, 0.6f) << "a hidden label, and tissue behind it";
    for (int column = 1; column < 4; ++column)
        EXPECT_EQ(on.at(hidden, column), on.at(all, column)) << column;
    on.labels() = withShown(on.list, on.labels(), liver, true);
    EXPECT_EQ(on.labels(), before);
    EXPECT_TRUE(haveSameBits(on.draw(), all));

    on.labels() = withAlone(on.list, before, spleen);
    EXPECT_THAT(on.labels().show, ElementsAre("012")) << "a label has the name 12";
    const Image alone = on.draw();
    EXPECT_GT(on.at(alone, 1).a, 0.99f);
    const auto blank = [&](const Image& image, int left, int right) { // columns of pixels
        for (int y = 0; y < image.size.y; ++y)
            for (int x = left; x < right; ++x)
                if (image.pixels[static_cast<std::size_t>(y * image.size.x + x)].a > 0)
                    return false;
        return true;
    };
    EXPECT_TRUE(blank(alone, 0, (on.pixel(0).x + on.pixel(1).x) / 2 - 2));
    EXPECT_TRUE(blank(alone, (on.pixel(1).x + on.pixel(2).x) / 2 + 2, alone.size.x));
    on.labels() = withAllShown(on.labels());
    EXPECT_TRUE(haveSameBits(on.draw(), all)) << "tissue is back as well";

    on.labels() = withColour(on.list, before, named12, {0, 0, 1});
    const Image blue = on.draw();
    EXPECT_NEAR(on.at(blue, 2).b, 1, 0.1);
    EXPECT_NEAR(on.at(blue, 2).r, 0, 0.1) << "tissue in front";
    EXPECT_EQ(on.at(blue, 1), on.at(all, 1)) << "of the value 12";
    on.labels() = withOpacity(on.list, before, named12, 0.01);
    const Image faint = on.draw();
    EXPECT_LT(on.at(faint, 2).a, 0.6f);
    EXPECT_GT(on.at(faint, 2).a, 0.05f);
    EXPECT_EQ(on.at(faint, 1), on.at(all, 1));
    on.labels() = withLook(before, LabelLook::tint);
    EXPECT_LT(on.at(on.draw(), 0).a, 0.9f) << "as faint as the tissue";
    on.labels() = withLook(before, LabelLook::plain);
    const Image plain = on.draw();
    EXPECT_NEAR(on.at(plain, 0).r, on.at(plain, 0).b, 0.01) << "in the tissue's white";
    on.labels() = withUnlabelled(before, false);
    const Image without = on.draw();
    EXPECT_TRUE(blank(without, 0, 2));
    EXPECT_FALSE(blank(all, 0, 2));
    on.labels() = before;
    EXPECT_TRUE(haveSameBits(on.draw(), all)) << "an edit undone left something";
}

TEST(LabelSession, StaysInItsBudgetsAndKeepsAPicture) {
    OnLabels on;
    const Labels before = on.labels();
    on.draw();
    for (int n = 0; n < 12; ++n) {
        on.labels() = withShown(on.list, before, Numbers{static_cast<std::size_t>(n % 4)}, false);
        on.looker.viewing->show(on.scene, n % 2 == 0);
        std::this_thread::sleep_for(std::chrono::milliseconds(7 * n));
        EXPECT_NE(on.looker.viewing->picture(), nullptr) << "a frame without a picture";
        const ViewingState s = on.looker.viewing->state();
        EXPECT_LE(s.ramUsed, kRamBytes);
        EXPECT_LE(s.gpuUsed, kGpuBytes);
        EXPECT_EQ(s.problem, "");
    }
}

TEST(LabelSession, PicksWhatIsSeen) {
    OnLabels on;
    on.draw();
    const std::uint32_t values[] = {3, 12, 40, 7};
    for (int column = 0; column < 4; ++column) {
        const PickedPlace place = on.pick(column);
        ASSERT_TRUE(place.hit) << column;
        EXPECT_THAT(place.labels, ElementsAre(values[column]));
        EXPECT_NEAR(place.voxel.y, 16.5, 1);
    }
    on.labels() = withAlone(on.list, on.labels(), Numbers{2});
    on.draw();
    EXPECT_FALSE(on.pick(0).hit) << "a hidden label, in tissue that does not show";
    EXPECT_THAT(on.pick(1).labels, ElementsAre(12));
    on.labels() = withUnlabelled(withShown(on.list, withAllShown(on.labels()), Numbers{0}, false), true);
    on.scene.volumes[0].transferFunction =
        TransferFunction::fromOpacity({{200, 0}, {300, 0.9}}, {{200, {1, 1, 1}}}, 1);
    on.draw();
    const PickedPlace tissue = on.pick(0);
    ASSERT_TRUE(tissue.hit);
    EXPECT_NEAR(tissue.voxel.y, 14.5, 1) << "before the label";
    EXPECT_TRUE(tissue.labels.empty());
    on.scene.mode = Mode::average; // draws no labels, but they are there
    on.scene.volumes[0].labels = withAllShown(on.labels());
    on.draw();
    EXPECT_THAT(on.pick(1).labels, ElementsAre(12));
}

TEST(LabelSession, SavedScenesOpenAgain) {
    OnLabels on(true);
    on.labels() = withColour(on.list, withAlone(on.list, on.labels(), Numbers{1, 2}), Numbers{2}, {1, 0, 0});
    on.labels().names = Labels::kTotalSegmentator;
    const auto still = on.looker.stillOf(on.looker.viewing->show(on.scene, false));
    const ScratchFolder elsewhere;
    std::ofstream(elsewhere / "saved.json") << sceneJson(on.scene);
    Looker again;
    const Scene opened = again.opened(elsewhere / "saved.json");
    EXPECT_EQ(sceneJson(opened), sceneJson(on.scene));
    EXPECT_TRUE(haveSameBits(again.stillOf(0)->image, still->image));
    EXPECT_THAT(still->manifest, ::testing::HasSubstr("labels-0.nrrd")) << "without its name";
    const auto states = labelStates(*again.viewing->volume()->labels, opened.volumes[0].labels);
    EXPECT_EQ(states[2].colour, glm::dvec3(1, 0, 0));
    EXPECT_FALSE(states[0].shows);
    EXPECT_TRUE(states[1].shows);
}

TEST(LabelSession, LabelsAreOpenedBesideAnOpenVolume) {
    const LabelledScan scan(kFour, 4);
    Looker looker(false);
    const Scene plain = looker.opened(scan.store);
    const Image before = looker.wholeOf(0)->image;
    looker.viewing->open(scan.file, kPicture);
    ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->volume()->labels != nullptr; }));
    const auto seen = looker.viewing->volume();
    EXPECT_EQ(seen->path, scan.store);
    EXPECT_EQ(seen->labels->size(), 5u);
    EXPECT_EQ(seen->scene.volumes[0].labels.path, scan.file);
    EXPECT_EQ(std::get<Camera>(seen->scene.camera), std::get<Camera>(plain.camera)) << "the view stays";
    const Image with = looker.wholeOf(looker.viewing->show(seen->scene, false))->image;
    EXPECT_FALSE(haveSameBits(with, before));
    Looker fresh(false);
    std::ofstream(scan.store.parent_path() / "fresh.json") << sceneJson(seen->scene);
    fresh.opened(scan.store.parent_path() / "fresh.json");
    EXPECT_TRUE(haveSameBits(fresh.wholeOf(0)->image, with));

    const fs::path broken = scan.store.parent_path() / "broken.seg.nrrd";
    std::ofstream(broken) << "NRRD0004\ntype: short\n";
    looker.viewing->open(broken, kPicture);
    ASSERT_TRUE(looker.comesTo([&] { return !looker.viewing->state().problem.empty(); }));
    EXPECT_THAT(looker.viewing->state().problem, ::testing::HasSubstr("as labels of the open volume"));
    EXPECT_THAT(looker.viewing->state().problem, ::testing::HasSubstr("broken.seg.nrrd"));
    EXPECT_EQ(looker.viewing->volume(), seen);
    looker.viewing->problemSeen();

    Scene surface = looker.viewing->volume()->scene; // beside which labels cannot be drawn
    surface.volumes[0].labels = {};
    surface.surfaces = {{300, {1, 1, 1}, 1}};
    const Image drawn = looker.wholeOf(looker.viewing->show(surface, false))->image;
    looker.viewing->open(scan.file, kPicture);
    ASSERT_TRUE(looker.comesTo([&] { return !looker.viewing->state().problem.empty(); }));
    EXPECT_EQ(looker.viewing->state().kind, ViewingState::Kind::open);
    looker.viewing->problemSeen();
    EXPECT_TRUE(haveSameBits(looker.wholeOf(looker.viewing->show(surface, false))->image, drawn));
}

/// A NIfTI file on the lattice of a LabelledScan, or beside it.
template <class T>
void writeNifti(const fs::path& file, std::int16_t type, const std::function<T(std::size_t)>& value,
                float shift = 0) {
    const glm::ivec3 e = LabelledScan::kExtent;
    std::string b(352, '\0');
    const auto put = [&](std::size_t at, auto number) { std::memcpy(&b[at], &number, sizeof number); };
    put(0, std::int32_t{348});
    for (std::size_t i = 0; i < 4; ++i)
        put(40 + 2 * i, static_cast<std::int16_t>(i == 0 ? 3 : e[static_cast<int>(i) - 1]));
    for (std::size_t i = 0; i < 4; ++i)
        put(76 + 4 * i, i == 0 ? 1.0F : 2.0F);
    put(70, type);
    put(72, static_cast<std::int16_t>(8 * sizeof(T)));
    put(108, 352.0F);
    b[123] = 2;
    put(254, std::int16_t{1});
    const float rows[12] = {-2, 0, 0, 10 + shift, 0, -2, 0, -8, 0, 0, 2, 6}; // RAS: the centre of voxel 0
    for (std::size_t i = 0; i < 12; ++i)
        put(280 + 4 * i, rows[i]);
    b.replace(344, 3, "n+1");
    for (std::size_t i = 0; i < cellCount(e); ++i) {
        const T typed = value(i);
        b.append(reinterpret_cast<const char*>(&typed), sizeof typed);
    }
    std::ofstream(file, std::ios::binary) << b;
}

template <class T>
void writeNrrd(const fs::path& file, const char* type, const std::function<T(std::size_t)>& value) {
    const glm::ivec3 e = LabelledScan::kExtent;
    std::ofstream out(file, std::ios::binary);
    out << "NRRD0004\ntype: " << type << "\ndimension: 3\nspace: left-posterior-superior\nsizes: " << e.x
        << " " << e.y << " " << e.z
        << "\nspace directions: (2,0,0) (0,2,0) (0,0,2)\nkinds: domain domain domain\n"
        << "endian: little\nencoding: raw\nspace origin: (-10,8,6)\n\n";
    for (std::size_t i = 0; i < cellCount(e); ++i) {
        const T typed = value(i);
        out.write(reinterpret_cast<const char*>(&typed), sizeof typed);
    }
}

/// A NIfTI or NRRD file may be labels or a volume.
TEST(LabelSession, WholeNumbersOnTheLatticeAreTakenAsLabels) {
    const LabelledScan scan(kFour, 4);
    const fs::path folder = scan.store.parent_path();
    const auto few = [](std::size_t i) { return static_cast<std::int16_t>(i / 7000 % 5); };
    writeNifti<std::int16_t>(folder / "organs.nii", 4, few);
    writeNifti<std::int16_t>(folder / "beside.nii", 4, few, 1);
    writeNifti<float>(folder / "floats.nii", 16, [&](std::size_t i) { return static_cast<float>(few(i)); });
    writeNifti<std::int16_t>(folder / "scan.nii", 4,
                             [](std::size_t i) { return static_cast<std::int16_t>(i % 300); });
    writeNifti<std::int16_t>(folder / "ct.nii", 4,
                             [](std::size_t i) { return static_cast<std::int16_t>(i < 90 ? -1000 : 40); });
    writeNrrd<std::int16_t>(folder / "organs.nrrd", "short", few);
    writeNrrd<float>(folder / "floats.nrrd", "float",
                     [&](std::size_t i) { return static_cast<float>(few(i)); });
    for (const char* name :
         {"organs.nii", "beside.nii", "floats.nii", "scan.nii", "ct.nii", "organs.nrrd", "floats.nrrd"}) {
        Looker looker(false);
        looker.opened(scan.store);
        looker.viewing->open(folder / name, kPicture);
        ASSERT_TRUE(looker.comesTo([&] {
            const auto seen = looker.viewing->volume();
            return seen && (seen->labels || seen->path != scan.store);
        })) << name;
        const auto seen = looker.viewing->volume();
        const bool isLabels = std::string(name).starts_with("organs.");
        EXPECT_EQ(seen->labels != nullptr, isLabels) << name;
        EXPECT_EQ(seen->path, isLabels ? scan.store : folder / name);
        EXPECT_EQ(seen->eitherFile, isLabels ? folder / name : fs::path());
        if (isLabels) {
            EXPECT_EQ(seen->labels->size(), 4u);
        }
    }
    Looker looker(false);
    looker.opened(scan.store);
    VolumePick asVolume;
    asVolume.asVolume = true;
    looker.viewing->open(folder / "organs.nii", kPicture, asVolume);
    ASSERT_TRUE(looker.comesTo([&] {
        const auto seen = looker.viewing->volume();
        return seen && seen->path == folder / "organs.nii";
    }));
    EXPECT_EQ(looker.viewing->volume()->labels, nullptr);
    looker.opened(scan.store);
    looker.viewing->open(scan.file, kPicture); // labels and nothing else
    ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->volume()->labels != nullptr; }));
    EXPECT_EQ(looker.viewing->volume()->eitherFile, fs::path());
}

/// A folder may be masks or volumes.
TEST(LabelSession, AFolderOfMasksIsTakenAsLabels) {
    const LabelledScan scan(kFour, 4);
    const fs::path folder = scan.store.parent_path();
    const auto mask = [&](const std::string& name, std::size_t from, std::size_t to, float shift = 0,
                          std::uint8_t inside = 1) {
        fs::create_directories((folder / name).parent_path());
        writeNifti<std::uint8_t>(
            folder / name, 2, [=](std::size_t i) { return i < from || i >= to ? std::uint8_t{0} : inside; },
            shift);
    };
    const auto scanFile = [&](const std::string& name) {
        writeNifti<std::int16_t>(folder / name, 4,
                                 [](std::size_t i) { return static_cast<std::int16_t>(i % 300); });
    };
    for (const char* kind : {"masks", "beside", "mixed", "nested", "dicom"}) {
        const std::string name = kind;
        mask(name + "/spleen.nii", 30000, 40000, name == "beside" ? 1.0F : 0.0F, 255);
        mask(name + "/liver.nii", 41000, 50000);
        mask(name + "/absent.nii", 0, 0);
        std::ofstream(folder / name / "statistics.json") << "{}";
        std::ofstream(folder / name / ".hidden") << "x";
    }
    scanFile("mixed/scan.nii");
    mask("ct/liver.nii", 41000, 50000);
    writeNifti<std::int16_t>(folder / "ct/ct.nii", 4,
                             [](std::size_t i) { return static_cast<std::int16_t>(i < 90 ? -1000 : 40); });
    fs::create_directories(folder / "nested/more");
    for (int z = 0; z < 4; ++z) {
        DicomImage image;
        image.pixels.assign(12, static_cast<std::uint16_t>(1000 + 100 * z));
        image.position = glm::dvec3(0, 0, 2 * z);
        fs::create_directories(folder / "series");
        writeDicom(folder / "series" / std::to_string(z), image);
        writeDicom(folder / "dicom" / std::to_string(z), image);
    }
    mask("nothing/absent.nii", 0, 0);
    mask("nothing/also.nii", 0, 0);
    mask("several/a.nii", 30000, 40000);
    writeNifti<std::uint8_t>(folder / "several/b.nii", 2,
                             [](std::size_t i) { return static_cast<std::uint8_t>(i % 3); });
    for (const char* kind :
         {"masks", "beside", "mixed", "nested", "dicom", "ct", "series", "nothing", "several"}) {
        SCOPED_TRACE(kind);
        Looker looker(false);
        looker.opened(scan.store);
        looker.viewing->open(folder / kind, kPicture);
        ASSERT_TRUE(looker.comesTo([&] {
            const auto seen = looker.viewing->volume();
            return looker.viewing->offers() || (seen && (seen->labels || seen->path != scan.store));
        }));
        const auto seen = looker.viewing->volume();
        if (std::string(kind) != "masks") {
            const bool isSeries =
                std::string(kind) == "series" || std::string(kind) == "dicom"; // its only CT
            EXPECT_FALSE(seen->labels);
            EXPECT_EQ(seen->path, isSeries ? folder / kind : scan.store);
            EXPECT_EQ(looker.viewing->offers() == nullptr, isSeries);
            continue;
        }
        ASSERT_TRUE(seen->labels);
        EXPECT_EQ(seen->path, scan.store);
        EXPECT_EQ(seen->eitherFile, folder / kind);
        std::vector<std::string> names;
        for (const auto& label : *seen->labels)
            names.push_back(label.name);
        EXPECT_THAT(names, ::testing::UnorderedElementsAre("absent", "liver", "spleen"));
        VolumePick asVolume;
        asVolume.asVolume = true;
        looker.viewing->open(folder / kind, kPicture, asVolume);
        EXPECT_TRUE(looker.comesTo([&] { return looker.viewing->offers() != nullptr; }));
    }
}

TEST(LabelSession, AThousandLabelsAreEditedInTime) {
    std::vector<std::pair<std::uint32_t, std::string>> thousand;
    for (std::uint32_t n = 0; n < 1000; ++n)
        thousand.emplace_back(n + 1, "structure " + std::to_string(n));
    const LabelledScan scan(thousand, 60);
    Looker looker(false);
    Scene scene = looker.opened(scan.scene(kPicture));
    const LabelList list = *looker.viewing->volume()->labels;
    ASSERT_EQ(list.size(), 1000u);
    looker.wholeOf(0);
    Numbers half, few = {5};
    for (std::size_t n = 0; n < 1000; n += 2)
        half.push_back(n);
    Labels& labels = scene.volumes[0].labels;
    const auto took = [&](const Labels& edited) {
        labels = edited;
        const auto began = std::chrono::steady_clock::now();
        const std::uint64_t wish = looker.viewing->show(scene, false);
        EXPECT_TRUE(looker.comesTo([&] {
            return looker.viewing->picture()->asked >= wish || !looker.viewing->state().problem.empty();
        }));
        EXPECT_EQ(looker.viewing->state().problem, "");
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
    };
    for (const double ms :
         {took(withShown(list, labels, few, false)), took(withShown(list, labels, half, false)),
          took(withColour(list, labels, half, {1, 0, 0})), took(withAllShown(labels))}) {
        std::printf("seen after %.0f ms\n", ms);
        EXPECT_LT(ms, 3000);
    }
}

} // namespace
} // namespace tessera::test
