// tests/bench/bench_tools.cpp: see bench_tools.h.
#include "tests/bench/bench_tools.h"

#include "bricking/import/importer.h"
#include "core/base/error.h"
#include "datasets/phantom.h"
#include "render/backends/gpu/features.h"
#include "render/backends/gpu/gpu_engine.h"
#include "render/picture/picture.h"
#include "render/residency/texels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace tessera::bench {

int runMain(const char* name, void (*run)(int, char**), int argc, char** argv) {
    try {
        run(argc, argv);
        return 0;
    } catch (const InputError& error) {
        std::fprintf(stderr, "%s: %s\n", name, error.what());
        return 2;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", name, error.what());
        return 1;
    }
}

double minimum(const std::vector<double>& values) {
    return *std::min_element(values.begin(), values.end());
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

SceneOnDevice::SceneOnDevice(const Scene& scene, const StoreReader& store, const GlContext& context,
                             Budgets& budgets)
    : scene_(scene), budgets_(budgets), engine_(context, budgets.gpu, budgets.ram) {
    scene_.imageSize = glm::ivec2(512); // the camera is fitted for a square; draw() names the real size
    prepared_ =
        planScene(scene_, store, engine_.limits(), {budgets.ram, budgets.gpu, 0}, LevelChoice::oneForAll);
    loadBricks(engine_, prepared_, budgets.gpu, upload_);
    prepared_.layer().cache.reset(); // every brick is on the device now
}

std::uint32_t SceneOnDevice::features(Fetch fetch) const {
    std::uint32_t f = 0;
    if (scene_.shading.on)
        f |= kFeatureShading;
    if (scene_.quality.skipping)
        f |= kFeatureSkipping;
    if (fetch == Fetch::hardware)
        f |= kFeatureHardware;
    if (texelFormat(prepared_.info().type).normalised)
        f |= kFeatureNormalised;
    if (scene_.quality.terminationTransmittance > 0)
        f |= kFeatureTermination;
    return f;
}

Frame SceneOnDevice::draw(const glm::ivec2& size, double stepVoxels, std::uint32_t features, Image* picture) {
    const FramePlan& p = prepared_;
    GpuCaster caster(p, engine_, features, budgets_.gpu);
    Strides strides = p.strides();
    strides.segmentVoxels = stepVoxels;
    caster.begin({rayFrame(p.view.camera, p.info(), size, stepVoxels), strides});
    Frame out;
    const auto start = Clock::now();
    drawToTheEnd(caster, engine_, p, Slicing{}, out.work);
    const auto reading = Clock::now();
    Image image = caster.image();
    out.ms = out.work.marchMs + msSince(reading);
    out.wallMs = msSince(start);
    if (picture)
        *picture = std::move(image);
    return out;
}

void MemorySource::readSlices(int count, std::span<std::byte> out) {
    (void)count; // out says the same in bytes
    TESSERA_CHECK(out.size() <= voxels_.size() - next_);
    std::memcpy(out.data(), voxels_.data() + next_, out.size());
    next_ += out.size();
}

namespace {

template <typename To>
void convert(const std::vector<std::byte>& from, std::vector<std::byte>& to, double bias) {
    for (std::size_t i = 0; i < from.size() / 2; ++i) {
        std::int16_t stored;
        std::memcpy(&stored, from.data() + 2 * i, 2);
        const To value = static_cast<To>(static_cast<double>(stored) + bias);
        std::memcpy(to.data() + sizeof(To) * i, &value, sizeof(To));
    }
}

} // namespace

MemoryVolume phantomInMemory(const std::string& name, const glm::ivec3& extent, ValueType type) {
    const auto source = makePhantom(name, extent);
    MemoryVolume volume{source->info(), {}};
    const std::size_t values = cellCount(extent);
    volume.voxels.resize(values * bytesPerValue(volume.info.type));
    source->readSlices(extent.z, volume.voxels);
    if (type == volume.info.type)
        return volume;
    TESSERA_CHECK(volume.info.type == ValueType::i16 && (type == ValueType::u16 || type == ValueType::f32));
    std::vector<std::byte> converted(values * bytesPerValue(type));
    const double bias = type == ValueType::u16 ? 32768 : 0;
    if (type == ValueType::u16)
        convert<std::uint16_t>(volume.voxels, converted, bias);
    else
        convert<float>(volume.voxels, converted, bias);
    volume.info.type = type;
    volume.info.fillStored += bias;
    volume.info.rescaleIntercept -= bias * volume.info.rescaleSlope;
    volume.voxels = std::move(converted);
    return volume;
}

std::map<std::string, std::string> parseOptions(int argc, char** argv,
                                                std::map<std::string, std::string> defaults) {
    for (int i = 1; i < argc; i += 2) {
        const auto at = defaults.find(argv[i]);
        if (at == defaults.end()) {
            std::string known;
            for (const auto& [name, value] : defaults)
                known += " " + name + " (" + value + ")";
            throw InputError(std::string(argv[i]) + ": expected one of" + known);
        }
        if (i + 1 >= argc)
            throw InputError(std::string(argv[i]) + ": expected a value after it");
        at->second = argv[i + 1];
    }
    return defaults;
}

std::vector<double> parseNumbers(const std::string& text, const std::string& option) {
    std::vector<double> numbers;
    for (const char* at = text.c_str(); *at;) {
        char* end = nullptr;
        const double value = std::strtod(at, &end);
        if (end == at || !(value > 0) || !std::isfinite(value) || (*end != '\0' && *end != ','))
            throw InputError(option + ": expected positive numbers with commas between, found \"" + text +
                             "\"");
        numbers.push_back(value);
        at = *end ? end + 1 : end;
    }
    return numbers;
}

glm::ivec3 parseExtent(const std::string& text, const std::string& option) {
    glm::ivec3 extent(0);
    char rest = 0;
    if (std::sscanf(text.c_str(), "%dx%dx%d%c", &extent.x, &extent.y, &extent.z, &rest) != 3 ||
        extent.x < 1 || extent.y < 1 || extent.z < 1)
        throw InputError(option + ": expected voxels as XxYxZ, found \"" + text + "\"");
    return extent;
}

void ensurePhantomStore(const std::filesystem::path& store, const std::string& name,
                        const glm::ivec3& extent) {
    if (std::filesystem::exists(store))
        return;
    std::fprintf(stderr, "making %s: %s, %dx%dx%d\n", store.c_str(), name.c_str(), extent.x, extent.y,
                 extent.z);
    if (store.has_parent_path())
        std::filesystem::create_directories(store.parent_path());
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30);
    importToStore(*makePhantom(name, extent), store, ram, ImportOptions{});
}

double loadAverage() {
    double load = -1;
    return ::getloadavg(&load, 1) == 1 ? load : -1;
}

} // namespace tessera::bench
