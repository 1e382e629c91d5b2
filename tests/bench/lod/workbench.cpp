// tests/bench/lod/workbench.cpp: see workbench.h.
#include "tests/bench/lod/workbench.h"

#include "bricking/import/importer.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/names.h"
#include "datasets/phantom.h"
#include "render/picture/picture.h"
#include "viewer/cli/input/volume_input.h"

#include <algorithm>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <optional>

namespace tessera::bench {
namespace {

namespace fs = std::filesystem;

/// Scans that are public, by the names of their files.
struct KnownScan {
    const char* name;
    const char* path; // inside the folder of scans
    const char* about;
    std::vector<std::string> presets;         // that levels of detail are measured with; none: they are not
    std::vector<std::string> calibrated = {}; // that promised errors are measured with; likewise
    bool seenBefore = false;

    const std::vector<std::string>& presetsFor(VolumeSet set) const {
        return set == VolumeSet::calibration ? calibrated : presets;
    }
    bool isIn(VolumeSet set) const { return set == VolumeSet::all || !presetsFor(set).empty(); }
};
const std::vector<KnownScan>& knownScans() {
    static const std::vector<KnownScan> scans = {
        {"abdomen",
         "ct-abdomen-dicom",
         "contrast-enhanced abdomen CT (pyvista/vtk-data, DICOM_Stack)",
         {"bone-1", "vessels-1", "soft-tissue"},
         {"bone-1", "soft-tissue", "vessels-1"},
         true},
        {"head",
         "ct-head-tilted-dicom",
         "head CT with a tilted gantry (neurolabusc/dcm_qa_ct)",
         {"bone-1", "skin-1"},
         {"skin-1", "bone-1"}},
        {"avm",
         "nifti/CT_AVM.nii.gz",
         "head CT angiography (neurolabusc/niivue-images, CT_AVM)",
         {"auto"},
         {"auto"},
         true},
        {"bonsai",
         "scivis/OpenSciVis/bonsai.nii.gz",
         "CT of a bonsai (neurolabusc/VolumeRenderingData)",
         {"auto"},
         {"auto"}},
        {"engine",
         "scivis/OpenSciVis/engine.nii.gz",
         "CT of an engine block (neurolabusc/VolumeRenderingData)",
         {"auto"},
         {"auto"}},
        {"thorax",
         "ct-thorax-dicom",
         "thorax CT, one phase of a 4D scan (ITKElastix examples)",
         {},
         {"bone-1", "lung-1"},
         true},
        {"slice", "ct-slice-encodings/CTImage.dcm", "one CT slice (cornerstone test images)", {}},
        {"pitch",
         "nifti/CT_pitch.nii.gz",
         "CT with an oblique affine (neurolabusc/niivue-images)",
         {},
         {"auto"}},
        {"fuel",
         "scivis/OpenSciVis/fuel.nii.gz",
         "simulated fuel injection (neurolabusc/VolumeRenderingData)",
         {},
         {"auto"}},
        {"avf",
         "nifti-nrrd-pair/nifti/marc_avf/avf_float_32.nii.gz",
         "MR angiography in floats (FNNDSC/data)",
         {},
         {"auto"}}};
    return scans;
}

BenchVolume makeTorso(const fs::path& folder, VolumeSet set, bool quick, std::size_t ramBytes) {
    const glm::ivec3 extent = quick ? glm::ivec3(96, 72, 112) : glm::ivec3(320, 240, 375);
    BenchVolume volume{"torso",
                       "generated torso phantom, " + formatExtent(extent) + " voxels",
                       folder / "torso.zarr",
                       {"bone-1", "soft-tissue"},
                       false,
                       true};
    if (set == VolumeSet::calibration)
        volume.presets = {"bone-1"};
    if (fs::exists(volume.store))
        return volume; // made for another set
    MemoryBudget ram("RAM", "--ram", ramBytes);
    ImportOptions options;
    options.durable = false;
    importToStore(*makePhantom("torso", extent), volume.store, ram, options);
    return volume;
}

Scene sceneOf(const BenchVolume& volume, const std::string& preset, const std::string& camera,
              const VolumeInfo& info, int pixels) {
    Scene scene;
    SceneVolume shown;
    shown.path = volume.store;
    shown.transferFunction = preset;
    scene.volumes = {shown};
    scene.imageSize = glm::ivec2(pixels);
    scene.camera = cameraNamed(camera, info, scene.imageSize);
    return scene;
}

constexpr std::size_t kAmpleGpuBytes = std::size_t{8} << 30; // these experiments count pages themselves

} // namespace

const std::vector<std::string>& studyEngineNames() {
    static const std::vector<std::string> names = {"auto", "gpu", "native"}; // in the order of EngineKind
    return names;
}

EngineKind studyEngine(const std::string& name) {
    const std::vector<std::string>& names = studyEngineNames();
    return static_cast<EngineKind>(indexOfName(name, names, "--engine"));
}

fs::path scansFolder(const std::string& told) {
    if (!told.empty()) {
        std::error_code ignored;
        if (!fs::is_directory(told, ignored))
            throw badFile(told, "a folder with scans", "none");
        return told;
    }
    const char* const data = std::getenv("TESSERA_TEST_DATA");
    return data ? fs::path(data) : fs::path();
}

std::vector<std::string> volumeNames(VolumeSet set) {
    std::vector<std::string> names = {"torso"};
    for (const KnownScan& scan : knownScans())
        if (scan.isIn(set))
            names.emplace_back(scan.name);
    return names;
}

Workbench makeWorkbench(EngineKind engine, const std::string& device, const fs::path& scansFolder,
                        VolumeSet set, const std::vector<std::string>& only, const fs::path& scratchFolder,
                        bool quick, std::size_t ramBytes, const CommonOptions& common) {
    Workbench bench{engine, device, {}, {}, quick, ramBytes, common, {}};
    const auto wanted = [&only](const std::string& name) {
        return only.empty() || std::find(only.begin(), only.end(), name) != only.end();
    };
    if (wanted("torso"))
        bench.volumes.push_back(makeTorso(scratchFolder, set, quick, ramBytes));
    else
        bench.leftOut.push_back("torso");
    for (const KnownScan& scan : knownScans()) {
        if (!scan.isIn(set))
            continue;
        const fs::path path = scansFolder / scan.path;
        if (!wanted(scan.name) || scansFolder.empty() || !fs::exists(path)) {
            bench.leftOut.push_back(scan.name);
            continue;
        }
        MemoryBudget ram("RAM", "--ram", ramBytes);
        InputOptions input;
        input.resampleZ = true;
        bench.volumes.push_back({scan.name, scan.about, storeFor(path, input, ram, common),
                                 scan.presetsFor(set), true, scan.seenBefore});
    }
    return bench;
}

void Workbench::begin(const std::string& name, std::size_t scenes) {
    experiment = name;
    parts = scenes;
    partsDone = 0;
    common.progress->stage("measuring: " + name);
}

void Workbench::done(const std::string& what) const {
    checkInterrupted();
    common.note(experiment + ": " + what + " done");
    if (parts > 0)
        common.progress->update(static_cast<double>(++partsDone) / static_cast<double>(parts));
}

std::size_t Workbench::scenes() const {
    std::size_t count = 0;
    for (const BenchVolume& volume : volumes)
        count += volume.presets.size();
    return count;
}

std::size_t floorNamed(const std::function<void(MemoryBudget&)>& draw) {
    const std::string before = "needs at least ";
    std::size_t bytes = 1;
    for (int trial = 0; trial < 5; ++trial)
        try {
            MemoryBudget gpu("GPU memory", "--gpu-memory", bytes);
            draw(gpu);
            return bytes;
        } catch (const InputError& error) {
            const std::string message = error.what();
            const std::size_t start = message.find(before);
            if (start == std::string::npos)
                throw;
            const std::size_t number = start + before.size();
            std::string text = message.substr(number, message.find_first_of("(,", number) - number);
            while (!text.empty() && text.back() == ' ')
                text.pop_back();
            bytes = parseBytes(text, "the floor that the program names");
        }
    throw Error("every floor that was named was too small: " + formatBytes(bytes));
}

Camera cameraNamed(const std::string& name, const VolumeInfo& info, const glm::ivec2& size) {
    if (name == "left")
        return fitCamera(info, View::left, Projection::parallel, size);
    Camera camera = fitCamera(info, View::anterior, Projection::perspective, size);
    if (name == "near") {
        const double distance = glm::length(camera.position - camera.focalPoint);
        camera.position = camera.focalPoint + 0.5 * distance * glm::normalize(glm::dvec3(0.5, -1, 0.4));
    } else if (name == "inside") {
        const auto at = [&](const glm::dvec3& share) {
            return glm::dvec3(info.patientFromVoxel * glm::dvec4(share * glm::dvec3(info.extentVoxels), 1));
        };
        camera.position = at({0.53, 0.31, 0.45});
        camera.focalPoint = at({0.2, 0.9, 0.7});
        camera.viewAngle = 110;
    } else {
        TESSERA_CHECK(name == "anterior");
    }
    return camera;
}

SceneBench::SceneBench(const Workbench& bench, const BenchVolume& volume, const std::string& preset,
                       const std::string& camera, int pixels, const Lighting& lighting)
    : bench_(bench), engines_(bench.engine, {bench.device}),
      name_(volume.name + ", " + preset + ", " + camera), ram_("RAM", "--ram", bench.ramBytes / 2),
      analysisRam_("RAM", "--ram", bench.ramBytes / 2), gpu_("GPU memory", "--gpu-memory", kAmpleGpuBytes),
      store_(volume.store, ram_) {
    const TextureLimits limits = engines_.make(ram_, gpu_)->limits();
    Scene scene = sceneOf(volume, preset, camera, store_.info(), bench.pixels());
    scene.lighting = lighting;
    prepared_ = planScene(scene, store_, limits, {ram_, gpu_, 0}, LevelChoice::oneForAll);
    if (pixels > 0)
        prepared_.view.frame =
            rayFrame(prepared_.view.camera, info(), glm::ivec2(pixels), prepared_.view.quality.stepVoxels);
    culled_ = cullBricks(prepared_.layer().statistics, prepared_.layer().table, info(), 0,
                         cullingFor(scene.shading));
    chooser_.emplace(store_, analysisRam_, 0);
    chooser_->setFunction(prepared_.layer().statistics, prepared_.layer().table, cullingFor(scene.shading));
    chooser_->keepFunction();
    chooser_->setCamera(prepared_.view.camera, scene.imageSize);
    visibility_ = chooser_->predictedVisibility();
}

Drawn SceneBench::draw(Selection selection, const Setting& setting) {
    Planner& p = prepared_;
    p.view.quality.edgeFunction = setting.edgeFunction;
    p.view.quality.sampling = setting.sampling;
    p.view.quality.skipping = setting.skipping;
    Drawn drawn;
    const std::unique_ptr<Engine> engine = engines_.make(ram_, gpu_);
    bring(*engine, std::move(selection), drawn.work);
    const auto caster = engine->caster({setting.counting, false, false}, gpu_);
    caster->begin(raysOf(p));
    drawToTheEnd(*caster, *engine, p, Slicing{}, drawn.work);
    drawn.image = caster->image();
    drawn.light = engine->lightReport();
    bench_.common.detail(name_ + ": drawn in " + formatNumber(drawn.work.marchMs, 3) + " ms");
    return drawn;
}

void SceneBench::bring(Engine& engine, Selection selection, Work& work) {
    prepared_.setSelection(std::move(selection));
    prepared_.chosen.atlasPages = std::max(pagesOf(prepared_.layer().selection), std::size_t{1});
    loadBricks(engine, prepared_, gpu_, work);
}

std::vector<float> SceneBench::countedVisibility(Selection selection) {
    Work work;
    const std::unique_ptr<Engine> engine = engines_.make(ram_, gpu_);
    bring(*engine, std::move(selection), work);
    const auto counter = engine->counter(gpu_);
    counter->begin();
    counter->count(Slicing{}, RayCaster::Clock::time_point::max());
    return visibilityFactors(counter->seen(), prepared_.layer().selection);
}

double SceneBench::reductionOf(const Selection& selection) const {
    const double texels =
        static_cast<double>(pagesOf(selection)) * kBrickExtent * kBrickExtent * kBrickExtent;
    return static_cast<double>(info().voxelCount()) / std::max(texels, 1.0);
}

std::vector<float> SceneBench::seenAt(double reduction) {
    return countedVisibility(chosenAt(reduction, visibility_));
}

Selection SceneBench::chosenAt(double reduction) {
    return chosenAt(reduction, seenAt(reduction));
}

Selection SceneBench::chosenAt(double reduction, Visibility visibility) const {
    return chooser_->best(culled_.means, pagesAt(reduction), visibility);
}

std::size_t SceneBench::pagesAt(double reduction) const {
    const double page = double{kBrickExtent} * kBrickExtent * kBrickExtent;
    return std::max(std::size_t{1},
                    static_cast<std::size_t>(static_cast<double>(info().voxelCount()) / page / reduction));
}

} // namespace tessera::bench
