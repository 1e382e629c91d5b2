// tests/viewer/session/session_test.cpp: the pictures of a session: at rest the same one as renderScene()
// draws, during movement one in time. Also the values under a point. A volume that cannot be opened gives a
// message, and nothing is lost.
#include "bricking/analysis/lumen/centreline.h"
#include "bricking/analysis/lumen/wall_coverage.h"
#include "bricking/import/importer.h"
#include "bricking/store/store_reader.h"
#include "core/base/program_folders.h"
#include "core/scene/preset.h"
#include "render/picture/render_scene.h"
#include "render/plan/frame_plan.h"
#include "tests/support/formula_source.h"
#include "tests/support/looker.h"
#include "tests/support/scene_fixture.h"
#include "viewer/session/background_work.h"
#include "viewer/session/view_geometry.h"
#include "viewer/session/view_session.h"

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mutex>
#include <thread>

namespace tessera::test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

bool sameBits(const Image& a, const Image& b) {
    return a.size == b.size &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(glm::vec4)) == 0;
}

TEST(ViewSession, AtRestShowsTheVeryPictureOfTheProgram) {
    Looker looker;
    Scene scene = looker.opened(storePath("torso"));
    const auto first = looker.stillOf(0);
    EXPECT_TRUE(sameBits(first->image, rendered(scene)));
    EXPECT_THAT(first->manifest, HasSubstr("not for diagnosis"));
    EXPECT_EQ(first->displaySize, kPicture);

    // After a camera that went its way, another function, a surface: without a trace of what was before.
    Camera camera = std::get<Camera>(scene.camera);
    std::uint64_t wish = 0;
    for (int n = 0; n < 12; ++n) {
        camera = orbited(camera, {0.1, 0.04});
        scene.camera = camera;
        wish = looker.viewing->show(scene, true);
        std::this_thread::sleep_for(5ms);
    }
    scene.volumes.front().transferFunction = presetFunction("soft-tissue", looker.viewing->volume()->values);
    looker.viewing->show(scene, true);
    scene.surfaces.push_back({300, {1, 0.9, 0.8}, 0.7});
    wish = looker.viewing->show(scene, false);
    const auto last = looker.stillOf(wish);
    EXPECT_TRUE(sameBits(last->image, rendered(scene)));
    EXPECT_FALSE(sameBits(last->image, first->image));
    EXPECT_TRUE(looker.comesTo([&] { return looker.viewing->state().atRest; }));
    EXPECT_THAT(looker.viewing->state().measured, HasSubstr("L*u*v*"));
    scene.camera = orbited(camera, {0.3, 0.1});
    wish = looker.viewing->show(scene, true); // moving: no still follows
    EXPECT_TRUE(looker.comesTo([&] {
        const auto picture = looker.viewing->picture();
        return picture && picture->asked >= wish;
    }));
    EXPECT_TRUE(looker.comesTo([&] { return looker.viewing->state().measured.empty(); }))
        << "the error of another picture";
}

// A scene saved from source files opened straight away has to open again when the cache is cleared.
TEST(ViewSession, ASceneNamesItsSourceAndNotTheCache) {
    const ScratchFolder folder;
    const fs::path source = folder / "ball.json", cache = folder / "cache";
    ::setenv("XDG_CACHE_HOME", cache.c_str(), 1);
    std::string voxels;
    for (int i = 0; i < 24 * 24 * 24; ++i)
        voxels += static_cast<char>(i % 24 * 5 + i / 24 % 24 * 3);
    std::ofstream(folder / "ball.raw", std::ios::binary) << voxels;
    std::ofstream(source) << R"({"data":"ball.raw","type":"uint8","extent":[24,24,24],"spacing":[1,1,1]})";
    Scene scene;
    {
        Looker looker(false);
        scene = looker.opened(source);
        looker.wholeOf(0);
    }
    EXPECT_EQ(scene.volumes.front().path, source);
    std::ofstream(folder / "saved.json") << sceneJson(scene);
    EXPECT_GT(fs::remove_all(cache), 1u);
    Looker again(false);
    EXPECT_EQ(sceneJson(again.opened(folder / "saved.json")), sceneJson(scene));
    again.wholeOf(0);
}

TEST(ViewSession, WhileSomethingMovesPicturesAreSmallerAndOfTheLastWish) {
    Looker looker;
    Scene scene = looker.opened(storePath("torso"));
    looker.stillOf(0);
    const std::uint64_t before = looker.viewing->state().pictures;
    scene.camera = orbited(std::get<Camera>(scene.camera), {0.5, 0});
    const std::uint64_t wish = looker.viewing->show(scene, true);
    ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->picture()->asked == wish; }));
    const auto moving = looker.viewing->picture();
    EXPECT_EQ(moving->stage, Stage::moving);
    EXPECT_EQ(moving->camera, std::get<Camera>(scene.camera));
    EXPECT_LE(moving->image.size.x, kPicture.x);
    EXPECT_EQ(moving->displaySize, kPicture);
    EXPECT_EQ(moving->display.size(), static_cast<std::size_t>(kPicture.x) * kPicture.y);
    // No still comes as long as more is promised.
    std::this_thread::sleep_for(300ms);
    EXPECT_EQ(looker.viewing->picture()->stage, Stage::moving);
    EXPECT_LE(looker.viewing->state().pictures, before + 3) << "a picture that nobody asked for";
    looker.stillOf(looker.viewing->show(scene, false));
}

// A camera by side, or from anywhere, is fitted to the visible region, function and picture of the request.
// It is the camera of `tessera render`, whatever was drawn before.
TEST(ViewSession, FitsCamerasToThePictureTheyAreFor) {
    const auto planned = [](Scene scene) {
        MemoryBudget ram("RAM", "--ram", kRamBytes / 2), gpu("GPU memory", "--gpu-memory", kGpuBytes / 2);
        const StoreReader store(scene.volumes.front().path, ram);
        RenderOptions options;
        options.engine = EngineKind::native;
        return renderScene(scene, store, ram, gpu, options).camera;
    };
    Looker looker(false);
    Scene scene = looker.opened(storePath("torso"));
    ASSERT_TRUE(looker.viewing->volume()->fitted);
    looker.wholeOf(0);
    const glm::ivec2 sizes[] = {kPicture, {60, 100}, {60, 100}, {120, 40}};
    const char* const presets[] = {"bone", "bone", "skin", "lung"};
    for (std::size_t n = 0; n < 4; ++n)
        for (const View view : {View::left, View::inferior}) {
            scene.imageSize = sizes[n];
            scene.volumes.front().transferFunction =
                presetFunction(presets[n], looker.viewing->volume()->values);
            FittedView asked;
            asked.view = view;
            asked.named = true;
            scene.camera = asked;
            const Camera expected = planned(scene);
            if (n % 2 == 1) // the same from axes
                asked = {View::anterior, Projection::perspective, Fit::shown, true, viewAxes(view)};
            scene.camera = asked;
            const auto whole = looker.wholeOf(looker.viewing->show(scene, false));
            EXPECT_EQ(whole->camera, expected)
                << presets[n] << ", " << viewNames()[static_cast<std::size_t>(view)];
            EXPECT_EQ(whole->image.size, sizes[n]);
        }
}

// A scene that cannot be drawn is refused by its number, at once, and the next scene is drawn.
TEST(ViewSession, SaysWhichWishCannotBeDrawn) {
    Looker looker(false);
    Scene scene = looker.opened(storePath("torso"));
    looker.wholeOf(0);
    EXPECT_EQ(looker.viewing->state().refused, 0u);
    Scene empty = scene;
    empty.mode = Mode::isosurface;
    const std::uint64_t wish = looker.viewing->show(empty, false);
    ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->state().refused == wish; }));
    EXPECT_TRUE(looker.viewing->state().atRest);
    EXPECT_THAT(looker.viewing->state().problem, HasSubstr("isosurface"));
    looker.viewing->problemSeen();
    const std::uint64_t next = looker.viewing->show(scene, false);
    EXPECT_FALSE(isBlank(looker.wholeOf(next)->image));
    EXPECT_LT(looker.viewing->state().refused, next);
}

TEST(ViewSession, CutsAndWindowsComeToWhatAFreshOneShows) {
    const auto box = [](const VolumeInfo& info, double part) {
        Cuts cuts;
        cuts.boxes.push_back(
            {glm::dvec3(0), part * glm::dvec3(info.extentVoxels), CropBox::Space::voxels, Keep::inside});
        return cuts;
    };
    for (const Mode mode : {Mode::composite, Mode::maximum}) {
        Looker edited(false), fresh(false);
        Scene scene = edited.opened(storePath("torso"));
        const VolumeInfo info = edited.viewing->volume()->info;
        scene.mode = mode;
        const Scene before = scene;
        const auto uncut = edited.wholeOf(edited.viewing->show(scene, false));
        scene.cuts = box(info, 0.7);
        edited.wholeOf(edited.viewing->show(scene, false));
        scene.cuts = box(info, 0.6);
        scene.window = GreyWindow{300, 900};
        const auto last = edited.wholeOf(edited.viewing->show(scene, false));
        fresh.opened(storePath("torso"));
        const auto expected = fresh.wholeOf(fresh.viewing->show(scene, false));
        EXPECT_TRUE(sameBits(last->image, expected->image)) << modeNames()[static_cast<std::size_t>(mode)];
        EXPECT_FALSE(sameBits(last->image, uncut->image)) << "nothing was cut";
        const auto undone = edited.wholeOf(edited.viewing->show(before, false));
        EXPECT_TRUE(sameBits(undone->image, uncut->image)) << "an edit undone left something";

        // Pictures of few pixels are cut, too.
        scene.cuts.boxes.front().high = glm::dvec3(0.5);
        const std::uint64_t wish = edited.viewing->show(scene, true);
        ASSERT_TRUE(edited.comesTo([&] { return edited.viewing->picture()->asked >= wish; }));
        EXPECT_EQ(edited.viewing->picture()->stage, Stage::moving);
        EXPECT_TRUE(isBlank(edited.viewing->picture()->image));
    }
}

TEST(ViewSession, SaysWhatCannotBeOpenedAndKeepsWhatIs) {
    Looker looker;
    const ScratchFolder folder;
    looker.viewing->open(folder / "nowhere.zarr", kPicture);
    ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->state().kind == ViewingState::Kind::failed; }));
    EXPECT_THAT(looker.viewing->state().what, HasSubstr("nowhere.zarr"));
    EXPECT_EQ(looker.viewing->volume(), nullptr);

    const Scene scene = looker.opened(storePath("torso"));
    const auto volume = looker.viewing->volume();
    std::ofstream(folder / "broken.json") << R"({"tesseraScene": 1, "volumes": [)";
    looker.viewing->open(folder / "broken.json", kPicture);
    ASSERT_TRUE(looker.comesTo([&] { return !looker.viewing->state().problem.empty(); }));
    EXPECT_THAT(looker.viewing->state().problem, HasSubstr("broken.json"));
    EXPECT_EQ(looker.viewing->state().kind, ViewingState::Kind::open);
    EXPECT_EQ(looker.viewing->volume(), volume);
    looker.viewing->problemSeen();
    EXPECT_EQ(looker.viewing->state().problem, "");
    EXPECT_TRUE(sameBits(looker.stillOf(looker.viewing->show(scene, false))->image, rendered(scene)));
}

// A store, and a scene that says otherwise: the keys of `--set` hold for whatever is opened, and nothing else
// of the scene changes.
TEST(ViewSession, KeysThatAreSetHoldForEverySceneThatIsOpened) {
    const ScratchFolder folder;
    const std::string path = storePath("torso");
    std::ofstream(folder / "scene.json") << R"({"tesseraScene":1,"volumes":[{"path":")" << path
                                         << R"(","transferFunction":"soft-tissue"}],"mode":"minimum",
        "camera":{"view":"left"},"shading":{"ambient":0.5,"diffuse":0.25},"quality":{"samples":3}})";
    Looker looker(true, kRamBytes,
                  {"mode=mip", "window=-20,400", "shading.ambient=0.75", "quality.samples=2"}),
        plain;
    for (const fs::path& opened : {fs::path(path), fs::path(folder / "scene.json")}) {
        const Scene scene = looker.opened(opened);
        EXPECT_EQ(scene.mode, Mode::maximum) << opened;
        EXPECT_EQ(scene.quality.pixels.samples, 2) << opened;
        Scene otherwise = plain.opened(opened);
        otherwise.mode = Mode::maximum;
        otherwise.window = GreyWindow{-20, 400};
        otherwise.shading.ambient = 0.75;
        otherwise.quality.pixels.samples = 2;
        otherwise.camera = scene.camera; // fitted to what the mode shows
        EXPECT_EQ(sceneJson(scene), sceneJson(otherwise)) << opened;
    }
    EXPECT_TRUE(sameBits(looker.stillOf(0)->image, rendered(looker.viewing->volume()->scene)));

    Looker refused(false, kRamBytes, {"isosurfaces[1].value=3"});
    refused.viewing->open(path, kPicture);
    ASSERT_TRUE(refused.comesTo([&] { return refused.viewing->state().kind == ViewingState::Kind::failed; }));
    EXPECT_THAT(refused.viewing->state().what, HasSubstr("--set isosurfaces[1].value: expected an item"));
}

TEST(ViewSession, WhatIsDamagedIsDrawnCoarserAndSaid) {
    const ScratchFolder folder;
    fs::copy(storePath("torso"), folder / "torso.zarr", fs::copy_options::recursive);
    // A byte in the middle of every file of level 0.
    for (const auto& file : fs::recursive_directory_iterator(folder / "torso.zarr" / "0" / "c"))
        if (file.is_regular_file() && file.file_size() > 4096) {
            std::fstream stream(file.path(), std::ios::in | std::ios::out | std::ios::binary);
            const auto middle = static_cast<std::streamoff>(file.file_size() / 2);
            stream.seekg(middle);
            const char flipped = static_cast<char>(stream.get() ^ 0x55);
            stream.seekp(middle);
            stream.put(flipped);
        }
    Looker looker;
    looker.opened(folder / "torso.zarr");
    ASSERT_TRUE(looker.comesTo([&] {
        const auto picture = looker.viewing->picture();
        return picture && picture->stage == Stage::whole && looker.viewing->state().damagedChunks > 0;
    }));
    EXPECT_FALSE(isBlank(looker.viewing->picture()->image));
    EXPECT_THAT(looker.viewing->state().problem, HasSubstr("torso.zarr"));
    EXPECT_EQ(looker.viewing->state().kind, ViewingState::Kind::open);
}

TEST(ViewSession, StaysInItsBudgets) {
    Looker looker;
    Scene scene = looker.opened(storePath("torso"));
    for (int n = 0; n < 10; ++n) {
        scene.camera = orbited(std::get<Camera>(scene.camera), {0.3, 0});
        looker.viewing->show(scene, n % 3 != 0);
        std::this_thread::sleep_for(30ms);
        const ViewingState s = looker.viewing->state();
        EXPECT_LE(s.ramUsed, kRamBytes);
        EXPECT_LE(s.gpuUsed, kGpuBytes);
        EXPECT_GT(s.ramUsed, 0u);
    }
}

TEST(ViewSession, APlaceOfThePictureIsWhereOneSeesSomething) {
    // A wall at y = 20 voxels of 2 mm: nothing before it, opaque behind; values rise on to the back.
    const ScratchFolder folder;
    VolumeInfo info;
    info.extentVoxels = {40, 48, 36};
    info.type = ValueType::i16;
    info.patientFromVoxel = glm::dmat4(2);
    info.patientFromVoxel[3] = {-11, 7, 5, 1};
    FormulaSource source(info, [](const glm::dvec3& p) { return p.y < 20 ? 0.0 : 500 + 10 * (p.y - 20); });
    MemoryBudget ram("RAM", "--ram", kRamBytes);
    importToStore(source, folder / "wall.zarr", ram, {});

    Looker looker;
    Scene scene = looker.opened(folder / "wall.zarr");
    scene.volumes.front().transferFunction =
        TransferFunction::fromOpacity({{300, 0}, {400, 0.9}}, {{300, {1, 1, 1}}}, 1);
    scene.camera = fitCamera(info, View::anterior, Projection::parallel, kPicture);
    looker.stillOf(looker.viewing->show(scene, false));
    const std::uint64_t question = looker.viewing->pick({kPicture.x / 2.0 + 7, kPicture.y / 2.0 - 5});
    ASSERT_TRUE(looker.comesTo(
        [&] { return looker.viewing->picked() && looker.viewing->picked()->number >= question; }));
    const PickedPlace place = *looker.viewing->picked();
    ASSERT_TRUE(place.hit);
    EXPECT_EQ(place.level, 0);
    EXPECT_NEAR(place.voxel.y, 20.5, 1.0) << "where opacity rises";
    EXPECT_NEAR(place.mm.y, 2 * place.voxel.y + 7, 1e-9);
    const Camera& camera = std::get<Camera>(scene.camera);
    const double mmPerPixel = 2 * camera.parallelScale / kPicture.y;
    EXPECT_NEAR(place.mm.x, camera.focalPoint.x + 7 * mmPerPixel, 1e-6) << "patient's left is at the right";
    EXPECT_NEAR(place.mm.z, camera.focalPoint.z + 5 * mmPerPixel, 1e-6);
    EXPECT_GT(place.value, 250);

    const std::uint64_t beside = looker.viewing->pick({0.5, 0.5});
    ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->picked()->number >= beside; }));
    EXPECT_FALSE(looker.viewing->picked()->hit) << "outside the volume";
}

// For values that rise along x, a disc's mean is the value at its middle, and its deviation half the rise
// over the radius, whatever its orientation. Outside of the volume there are none.
TEST(ViewSession, ACircleTellsTheValuesThatItHolds) {
    const ScratchFolder folder;
    VolumeInfo info;
    info.extentVoxels = {80, 70, 60};
    info.type = ValueType::f32;
    info.patientFromVoxel = glm::dmat4(2);
    info.patientFromVoxel[3] = {-11, 7, 5, 1};
    FormulaSource source(info, [](const glm::dvec3& p) { return 100 + 3 * p.x; }); // 1.5 per mm
    MemoryBudget ram("RAM", "--ram", kRamBytes);
    importToStore(source, folder / "ramp.zarr", ram, {});
    Looker looker(false);
    looker.opened(folder / "ramp.zarr");
    const auto valuesOf = [&](const glm::dvec3& centre, double radius, const glm::dvec3& u,
                              const glm::dvec3& v) {
        Measurement circle{MeasurementKind::circle,
                           {centre + radius * u, centre + radius * v, centre - radius * u}};
        const std::uint64_t question = looker.viewing->askValues(circle);
        EXPECT_TRUE(looker.comesTo([&] {
            return looker.viewing->discValues() && looker.viewing->discValues()->number == question;
        }));
        return *looker.viewing->discValues();
    };
    const glm::dvec3 centre = glm::dvec3(2.0 * 40, 2.0 * 35, 2.0 * 30) + glm::dvec3(-11, 7, 5);
    const double atCentre = 100 + 3 * 40;
    for (const double radius : {8.0, 25.0}) {
        const DiscValues flat = valuesOf(centre, radius, {1, 0, 0}, {0, 1, 0});
        EXPECT_NEAR(flat.mean, atCentre, 0.02 * radius);
        EXPECT_NEAR(flat.deviation, 1.5 * radius / 2, 0.03 * radius);
        EXPECT_NEAR(flat.most - flat.least, 2 * 1.5 * radius, 0.2 * radius);
        const DiscValues across = valuesOf(centre, radius, {0, 1, 0}, {0, 0, 1});
        EXPECT_NEAR(across.mean, atCentre, 1e-3) << "all of one x";
        EXPECT_NEAR(across.deviation, 0, 1e-3);
        EXPECT_GT(across.samples, 100u);
    }
    EXPECT_EQ(valuesOf({5000, 0, 0}, 8, {1, 0, 0}, {0, 1, 0}).samples, 0u);
    EXPECT_EQ(valuesOf(centre, 8, {1, 0, 0}, {0.5, 0, 0}).samples, 0u) << "a line is no circle";
}

TEST(Still, IsCalledOffAtOnce) {
    MemoryBudget ram("RAM", "--ram", kRamBytes), gpu("GPU memory", "--gpu-memory", kGpuBytes);
    const StoreReader store(storePath("torso"), ram);
    Scene scene = sceneOn(store.info(), "soft-tissue", 0, {1024, 1024});
    scene.quality.pixels.samples = 64; // some seconds
    scene.quality.stepVoxels = 0.125;
    RenderOptions options;
    options.engine = EngineKind::native;
    std::mutex mutex;
    std::condition_variable changed;
    bool ended = false;
    const auto began = std::chrono::steady_clock::now();
    Still still(scene, 7, {&store}, ram, gpu, options, [&] {
        const std::lock_guard lock(mutex);
        ended = true;
        changed.notify_all();
    });
    std::this_thread::sleep_for(200ms);
    still.callOff();
    std::unique_lock lock(mutex);
    ASSERT_TRUE(changed.wait_for(lock, 20s, [&] { return ended; }));
    EXPECT_EQ(still.take().picture, nullptr)
        << "it ended by itself, after " << (std::chrono::steady_clock::now() - began) / 1ms << " ms";
}

// A request that changes nothing may come before the picture of the request that did: no older picture
// answers it.
TEST(ViewSession, AnOlderPictureAnswersNoWish) {
    Looker looker(false);
    Scene scene = looker.opened(storePath("torso"));
    looker.wholeOf(0);
    for (int n = 0; n < 20; ++n) {
        scene.camera = orbited(std::get<Camera>(scene.camera), {0.2, 0});
        scene.surfaces = {{300.0 + n, {1, 1, 1}, 1}}; // another renderer, whose first picture takes a while
        looker.viewing->show(scene, true);
        std::this_thread::sleep_for(2ms * n);
        const std::uint64_t wish = looker.viewing->show(scene, true);
        ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->picture()->asked >= wish; }));
        EXPECT_TRUE(looker.viewing->picture()->camera == std::get<Camera>(scene.camera)) << n;
    }
}

// RAM in which pictures fit, but not beside a still: there are pictures, and it is said that nothing finer
// comes.
TEST(ViewSession, StillsAreLeftOutWhereThereIsNoRoom) {
    std::size_t least = 0;
    {
        MemoryBudget ram("RAM", "--ram", kRamBytes);
        least = renderFloorBytes(StoreReader(storePath("torso"), ram).info(), kPicture, kPictureBytesPerPixel,
                                 0, Scene().quality.integrator);
    }
    const std::size_t tight = 2 * least; // of which half less an eighth is not enough
    Looker looker(true, tight);
    const Scene scene = looker.opened(storePath("torso"));
    const auto whole = looker.wholeOf(0);
    EXPECT_EQ(whole->image.size, scene.imageSize);
    EXPECT_TRUE(looker.viewing->state().noStills);
    EXPECT_FALSE(looker.viewing->state().drawingStill);
    EXPECT_LE(looker.viewing->state().ramUsed, tight);
    Looker ample;
    ample.opened(storePath("torso"));
    ample.stillOf(0);
    EXPECT_FALSE(ample.viewing->state().noStills);
}

// A picture too large for the memory is refused with a sentence; the next one is drawn.
TEST(ViewSession, APictureThatDoesNotFitLosesNothing) {
    Looker looker;
    Scene scene = looker.opened(storePath("torso"));
    looker.stillOf(0);
    Scene huge = scene;
    huge.imageSize = {4000, 4000};
    looker.viewing->show(huge, false);
    ASSERT_TRUE(looker.comesTo([&] { return !looker.viewing->state().problem.empty(); }));
    EXPECT_THAT(looker.viewing->state().problem, HasSubstr("--ram"));
    looker.viewing->problemSeen();
    looker.viewing->pick({20, 20}); // nothing is drawn: no answer
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    looker.viewing->show(huge, true); // again, as a window does whose size stays
    ASSERT_TRUE(looker.comesTo([&] { return !looker.viewing->state().problem.empty(); }));
    looker.viewing->problemSeen();
    scene.imageSize = {80, 60};
    const auto still = looker.stillOf(looker.viewing->show(scene, false));
    EXPECT_EQ(still->image.size, glm::ivec2(80, 60));
    EXPECT_TRUE(sameBits(still->image, rendered(scene)));
}

// A line is looked for beside all else; stills come back after it.
TEST(ViewSession, FindsLines) {
    Looker looker;
    const Scene scene = looker.opened(storePath("torso"));
    const auto comes = [&](std::uint64_t number) {
        return looker.comesTo([&] {
            const LineState line = looker.viewing->line();
            return !line.searching && line.number == number;
        });
    };
    LineWish wish;
    wish.places = {{-67, -33, -155}, {0, 38, -200}}; // of the phantom's colon
    ASSERT_TRUE(comes(looker.viewing->findLine(wish)));
    const LineState found = looker.viewing->line();
    ASSERT_TRUE(found.path) << found.problem;
    EXPECT_THAT(found.about, HasSubstr("a line of"));
    CentrelineRequest request;
    request.seeds = {{wish.places[0], "a"}, {wish.places[1], "b"}};
    MemoryBudget ram("RAM", "--ram", kRamBytes);
    const StoreReader store(storePath("torso"), ram);
    Progress progress(Verbosity::quiet, false);
    EXPECT_EQ(found.path->lines, findCentrelines(store, request, ram, progress).lines);
    EXPECT_EQ(found.path->volume->contentHash, store.contentHash());

    LineWish along;
    along.seenAlong = found.path;
    along.aspect = 2;
    along.bothWays = true;
    ASSERT_TRUE(comes(looker.viewing->findLine(along)));
    CoverageRequest coverage;
    coverage.lines = found.path->lines;
    coverage.flight = *found.path->flight;
    coverage.lumen = *found.path->lumen;
    coverage.cameras = flightCameras(*found.path, 1, true);
    coverage.aspect = 2;
    const WallCoverage measured = measureWallCoverage(store, coverage, ram, progress);
    ASSERT_TRUE(looker.viewing->line().coverage) << looker.viewing->line().problem;
    EXPECT_EQ(looker.viewing->line().coverage->seenMm2, measured.seenMm2);
    EXPECT_EQ(looker.viewing->line().coverage->patches.size(), measured.patches.size());
    EXPECT_GT(measured.share(), 0.5);
    EXPECT_THAT(looker.viewing->line().about, HasSubstr("cm2 of wall"));

    wish.places[0] = {0, 0, 1e5}; // outside: said, and nothing is lost
    ASSERT_TRUE(comes(looker.viewing->findLine(wish)));
    EXPECT_THAT(looker.viewing->line().problem, HasSubstr("place 1"));
    EXPECT_FALSE(looker.viewing->line().path);

    wish.places[0] = {-67, -33, -155};
    const std::uint64_t last = looker.viewing->findLine(wish);
    looker.viewing->callOffLine();
    ASSERT_TRUE(comes(last));
    EXPECT_EQ(looker.viewing->line().problem, "");
    const auto still = looker.stillOf(0);
    EXPECT_TRUE(sameBits(still->image, rendered(scene)));
}

} // namespace
} // namespace tessera::test
