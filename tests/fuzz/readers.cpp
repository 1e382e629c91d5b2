// tests/fuzz/readers.cpp: see readers.h.
#include "tests/fuzz/readers.h"

#include "bricking/import/files/hdf5/h5_bytes.h"
#include "bricking/import/files/stack/picture_walk.h"
#include "bricking/import/open_source.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "bricking/store/dct_codec.h"
#include "bricking/store/pyramid.h"
#include "bricking/store/shard.h"
#include "bricking/store/zarr_metadata.h"
#include "core/animation/path.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "core/scene/scene.h"
#include "core/scene/scene_presets.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/folders.h"
#include "tests/support/hdf5_corpus.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& path, const std::string& bytes) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

const fs::path& folder() {
    static const ScratchFolder scratch;
    return scratch.path();
}

/// Opens a volume and reads it where it is small: what it says of its size is a claim.
void readVolume(const fs::path& path) {
    constexpr std::size_t kMostVoxels = std::size_t{1} << 20;
    SourceOptions options;
    options.scratchFolder = folder();
    options.spacingMm = glm::dvec3(1);
    std::unique_ptr<SlabSource> source;
    try {
        source = openSource(path, options);
    } catch (const InputError&) { // or one that says its spacing
        options.spacingMm.reset();
        source = openSource(path, options);
    }
    const VolumeInfo& info = source->info();
    info.validate("a volume that was taken");
    if (info.voxelCount() > kMostVoxels)
        return;
    std::vector<std::byte> slice(sliceBytesOf(info));
    for (int z = 0; z < info.extentVoxels.z; ++z)
        source->readSlices(1, slice);
    static_cast<void>(source->notes());
}

/// False: refused.
template <typename Body> bool orRefused(const Body& body) {
    try {
        body();
        return true;
    } catch (const Error& refusal) {
        if (std::getenv("FUZZ_SAYS"))
            std::fprintf(stderr, "%s\n", refusal.what());
        return false;
    }
}

template <const char* Name> bool readFile(const std::string& bytes) {
    write(folder() / Name, bytes);
    return orRefused([] { readVolume(folder() / Name); });
}

/// Each volume of an HDF5 file. Checksums are not compared: damage would seldom pass them.
bool readHdf5(const std::string& bytes) {
    h5ChecksumsCount = false;
    const fs::path path = folder() / "a.h5";
    write(path, bytes);
    return orRefused([&] {
        constexpr std::uint64_t kMostVoxels = std::uint64_t{1} << 20;
        for (const Hdf5Volume& volume : openHdf5Volumes(path)) {
            const VolumeInfo& info = volume.source->info();
            info.validate("a volume that was taken");
            std::vector<std::byte> slice(info.voxelCount() > kMostVoxels ? 0 : sliceBytesOf(info));
            for (int z = 0; z < info.extentVoxels.z && !slice.empty(); ++z)
                volume.source->readSlices(1, slice);
        }
    });
}

/// A sidecar beside its data.
bool readRaw(const std::string& bytes) {
    write(folder() / "a.raw", std::string(148, '\1'));
    write(folder() / "a.json", bytes);
    return orRefused([] { readVolume(folder() / "a.json"); });
}

// Zarr: a document of metadata, a zero byte, then the first chunk.
bool readZarr(const std::string& bytes, const char* metadata, const char* chunk,
              const std::string& inside = {}) {
    static int number = 0;
    const fs::path array = folder() / ("zarr" + std::to_string(number++));
    if (!inside.empty())
        write(array / "0/0.0.0.0", inside);
    const std::size_t end = std::min(bytes.find('\0'), bytes.size());
    write(array / metadata, bytes.substr(0, end));
    if (end < bytes.size())
        write(array / chunk, bytes.substr(end + 1));
    const bool isTaken = orRefused([&] { readVolume(array); });
    std::error_code none;
    fs::remove_all(array, none);
    return isTaken;
}
bool readZarr3(const std::string& bytes) {
    return readZarr(bytes, "zarr.json", "c/0/0/0");
}
bool readZarr2(const std::string& bytes) {
    return readZarr(bytes, ".zarray", "0.0.0");
}
bool readOmeZarr(const std::string& bytes) {
    return readZarr(bytes, ".zattrs", "0/.zarray", std::string(48, '\1'));
}

/// The group of a store, with a checksum that fits.
bool readGroup(const std::string& bytes) {
    return orRefused([&] {
        Json group = parseJson(bytes, "zarr.json");
        if (const Json::json_pointer own("/attributes/tessera");
            !group.contains(own) || !group.at(own).is_object())
            throw Error("nothing to seal");
        seal(group);
        static_cast<void>(parseGroup(storedText(group), "zarr.json"));
    });
}

std::vector<std::byte> asBytes(const std::string& text) {
    const auto* const begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
}

/// The index of a shard, likewise.
bool readIndex(const std::string& bytes) {
    std::vector<std::byte> index = asBytes(bytes.substr(0, bytes.size() / 16 * 16));
    index.resize(std::max<std::size_t>(index.size(), 16)); // a shard has a chunk at least
    const std::uint32_t crc = crc32c(index);
    const auto* const tail = reinterpret_cast<const std::byte*>(&crc);
    index.insert(index.end(), tail, tail + sizeof crc);
    return orRefused([&] {
        for (const ShardEntry& entry : decodeIndex(index, 1 << 20, "a shard"))
            if (!entry.absent() && (entry.offset > 1 << 20 || entry.bytes > (1 << 20) - entry.offset))
                throw std::logic_error("an entry beyond the shard");
    });
}

bool readChunk(const std::string& bytes) {
    std::vector<std::byte> encoded = asBytes(bytes), raw(2048);
    const std::uint32_t crc = crc32c(encoded);
    const auto* const tail = reinterpret_cast<const std::byte*>(&crc);
    encoded.insert(encoded.end(), tail, tail + sizeof crc);
    return orRefused([&] { decodeChunk(encoded, raw, "a chunk"); });
}

bool readDct(const std::string& bytes) {
    std::vector<std::byte> raw(cellCount(glm::ivec3(kChunkExtent)) * 2);
    return orRefused([&] { decodeByDct(asBytes(bytes), raw, "a chunk", Codec::dct32); });
}

bool readPicture(const std::string& bytes) {
    write(folder() / "picture", bytes);
    return orRefused([] {
        const InputFile file(folder() / "picture");
        static_cast<void>(walkPicture(file));
    });
}

bool readScene(const std::string& bytes) {
    return orRefused([&] {
        const Scene scene = parseScene(bytes, "/nowhere", "scene");
        const std::string text = sceneJson(scene);
        if (sceneJson(parseScene(text, "/nowhere", "again")) != text)
            throw std::logic_error("a scene that reads otherwise once it is written");
    });
}

bool readPath(const std::string& bytes) {
    return orRefused([&] { static_cast<void>(parsePath(bytes, "path")); });
}

bool readPreset(const std::string& bytes) {
    return orRefused([&] { static_cast<void>(parsePreset(bytes, "preset", "preset")); });
}

// Seeds.

std::string words(std::size_t count) {
    std::string bytes;
    for (std::size_t i = 0; i < count; ++i) {
        bytes += static_cast<char>(i * 7);
        bytes += static_cast<char>(i % 5);
    }
    return bytes;
}

template <typename T> void put(std::string& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

std::string nifti() {
    std::string bytes(352 + 2 * 24, '\0');
    put(bytes, 0, std::int32_t{348});
    const std::int16_t dim[] = {3, 4, 3, 2, 1, 1, 1, 1};
    std::memcpy(bytes.data() + 40, dim, sizeof dim);
    put(bytes, 70, std::int16_t{4});
    put(bytes, 72, std::int16_t{16});
    for (int i = 0; i < 4; ++i)
        put(bytes, 76 + 4 * static_cast<std::size_t>(i), 1.0f);
    put(bytes, 108, 352.0f);
    put(bytes, 112, 1.0f);
    bytes[123] = 2;
    put(bytes, 254, std::int16_t{1}); // sform
    for (std::size_t row = 0; row < 3; ++row)
        put(bytes, 280 + 16 * row + 4 * row, 1.0f);
    bytes.replace(344, 4, std::string("n+1\0", 4));
    bytes.replace(352, 48, words(24));
    return bytes;
}

std::string tiff() {
    std::string bytes("II*\0\x08\0\0\0", 8);
    const std::vector<std::array<std::uint32_t, 4>> entries = {
        {256, 3, 1, 4},   {257, 3, 1, 3}, {258, 3, 1, 8}, {259, 3, 1, 1}, {262, 3, 1, 1},
        {273, 4, 1, 200}, {277, 3, 1, 1}, {278, 3, 1, 3}, {279, 4, 1, 12}};
    bytes += static_cast<char>(entries.size());
    bytes += '\0';
    for (const auto& [tag, type, count, value] : entries) {
        std::string entry(12, '\0');
        put(entry, 0, static_cast<std::uint16_t>(tag));
        put(entry, 2, static_cast<std::uint16_t>(type));
        put(entry, 4, count);
        put(entry, 8, value);
        bytes += entry;
    }
    bytes.resize(212, '\0');
    return bytes;
}

std::vector<std::string> zarr3Seeds() {
    const char* const head = R"({"zarr_format":3,"node_type":"array","shape":[2,3,4],"data_type":"int16",)"
                             R"("chunk_grid":{"name":"regular","configuration":{"chunk_shape":[2,3,4]}},)"
                             R"("chunk_key_encoding":{"name":"default","configuration":{"separator":"/"}},)"
                             R"("fill_value":0,"codecs":)";
    const std::string bytesCodec = R"({"name":"bytes","configuration":{"endian":"little"}})";
    const std::string plain = head + ("[" + bytesCodec + "]}"), body = words(24);
    return {plain + '\0' + body,
            head + ("[" + bytesCodec + R"(,{"name":"zstd","configuration":{"level":1}}]})"),
            head + (R"([{"name":"sharding_indexed","configuration":{"chunk_shape":[1,3,4],"codecs":[)" +
                    bytesCodec + R"(],"index_codecs":[)" + bytesCodec + R"(,{"name":"crc32c"}]}}]})" + '\0' +
                    body)};
}
std::vector<std::string> zarr2Seeds() {
    const auto with = [](const std::string& compressor) {
        return R"({"zarr_format":2,"shape":[2,3,4],"chunks":[2,3,4],"dtype":"<i2","compressor":)" +
               compressor + R"(,"fill_value":0,"order":"C","filters":null})" + '\0' + words(24);
    };
    return {with("null"), with(R"({"id":"lz4"})"), with(R"({"id":"zlib"})"), with(R"({"id":"blosc"})"),
            with(R"({"id":"zstd"})")};
}
std::vector<std::string> omeSeeds() {
    return {
        R"({"multiscales":[{"version":"0.4","axes":[{"name":"c","type":"channel"},{"name":"z","type":"space","unit":"millimeter"},)"
        R"({"name":"y","type":"space","unit":"millimeter"},{"name":"x","type":"space","unit":"mm"}],"datasets":[{"path":"0","coordinateTransformations":)"
        R"([{"type":"scale","scale":[1,2,0.5,0.5]},{"type":"translation","translation":[0,1,2,3]}]}]}],)"
        R"("omero":{"channels":[{"label":"a"},{"label":"b"}]}})" +
        std::string(1, '\0') +
        R"({"zarr_format":2,"shape":[1,2,3,4],"chunks":[1,2,3,4],"dtype":"<u2","compressor":null,"fill_value":7,"order":"F","filters":null})"};
}
std::vector<std::string> groupSeeds() {
    VolumeInfo info;
    info.extentVoxels = {40, 33, 20};
    info.type = ValueType::i16;
    StoreMetadata metadata;
    metadata.info = info;
    metadata.rule = kPyramidRule;
    for (int level = 0; level < kLevelCount; ++level)
        metadata.shards[static_cast<std::size_t>(level)].resize(
            cellCount(shardLayout(levelExtent(info.extentVoxels, level)).shards));
    return {groupDocument(metadata)};
}
std::vector<std::string> indexSeeds() {
    std::string index(4 * 16, '\xff');
    put(index, 0, std::uint64_t{0});
    put(index, 8, std::uint64_t{100});
    return {index};
}
std::vector<std::string> dctSeeds() {
    std::vector<std::string> seeds;
    for (const int size : {0, 13, kChunkExtent}) {
        std::vector<std::byte> raw(cellCount(glm::ivec3(kChunkExtent)) * 2);
        for (int n = 0; n < size * size * size; ++n)
            raw[2 * linearIndex({n % size, n / size % size, n / (size * size)}, glm::ivec3(kChunkExtent))] =
                static_cast<std::byte>(n / 7);
        if (size == kChunkExtent)
            withDctSteps(raw, 2, true, Codec::dct32);
        std::vector<std::byte> out(encodedBound(raw.size()));
        out.resize(encodeByDct(raw, 2, out, Codec::dct32));
        seeds.emplace_back(reinterpret_cast<const char*>(out.data()), out.size());
    }
    return seeds;
}

std::vector<std::string> chunkSeeds() {
    std::vector<std::byte> raw(2048), encoded(encodedBound(raw.size()));
    for (std::size_t i = 0; i < raw.size(); ++i)
        raw[i] = static_cast<std::byte>(i / 5);
    const EncodedChunk chunk = encodeChunk(raw, 2, encoded);
    return {std::string(reinterpret_cast<const char*>(encoded.data()), chunk.bytes - sizeof(std::uint32_t))};
}
std::vector<std::string> nrrdSeeds() {
    const std::string head =
        "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 3 2\n"
        "space directions: (1,0,0) (0,1,0) (0,0,2)\nkinds: domain domain domain\n"
        "endian: little\nspace origin: (0,0,0)\n";
    return {head + "encoding: raw\n\n" + words(24), head + "encoding: gzip\n\n" + words(24),
            head + "encoding: ascii\n\n1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24\n"};
}
std::vector<std::string> metaSeeds() {
    return {"ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = "
            "False\nCompressedData = False\n"
            "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 2\nDimSize = 4 3 2\n"
            "ElementType = MET_SHORT\nElementDataFile = LOCAL\n" +
            words(24)};
}
std::vector<std::string> vtiSeeds() {
    return {
        R"(<?xml version="1.0"?><VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">)"
        R"(<ImageData WholeExtent="0 1 0 1 0 1" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 1 0 1 0 1">)"
        R"(<PointData Scalars="v"><DataArray type="Int16" Name="v" format="ascii">1 2 3 4 5 6 7 8</DataArray></PointData>)"
        R"(</Piece></ImageData></VTKFile>)"};
}
std::vector<std::string> niftiSeeds() {
    return {nifti()};
}
std::vector<std::string> pictureSeeds() {
    std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\4\0\0\0\3\x10\0\0\0\0\0\0\0\0\0\0\0\4IDAT\x78\x9c\3"
                    "\0\0\0\0\0\0\0\0\0IEND\xae\x42\x60\x82",
                    61);
    return {tiff(), png};
}
std::vector<std::string> sceneSeeds() {
    Scene scene;
    scene.volumes.resize(2);
    for (SceneVolume& volume : scene.volumes)
        volume.path = "/a.zarr";
    scene.lighting.lights.resize(1);
    return {
        sceneJson(scene),
        R"({"tesseraScene":1,"volumes":[{"path":"a.zarr","preset":"bone"}],"isosurfaces":[{"value":300}]})"};
}
std::vector<std::string> pathSeeds() {
    Path path;
    path.lines.resize(1);
    CentreLine& line = path.lines.front();
    line.points = {{0, 0, 0}, {0, 0, 10}, {0, 6, 18}};
    line.radiusMm = {3, 4, 5};
    line.spacingMm = 10;
    return {pathJson(path)};
}
std::vector<std::string> presetSeeds() {
    std::ifstream bone(sourceFolder() / "core/scene/presets/bone.json");
    return {std::string{std::istreambuf_iterator<char>(bone), {}}};
}

constexpr char kNrrd[] = "a.nrrd", kMeta[] = "a.mha", kVti[] = "a.vti", kNifti[] = "a.nii",
               kDicom[] = "a.dcm";

std::vector<std::string> hdf5Seeds() {
    std::vector<std::string> seeds;
    for (const fs::path& path : hdf5Files(false)) {
        std::ifstream file(path, std::ios::binary);
        seeds.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
    return seeds;
}
std::vector<std::string> rawSeeds() {
    return {R"({"data":"a.raw","type":"int16","extent":[4,3,2],"spacing":[1,1,2],"offset":100})"};
}
std::vector<std::string> dicomSeeds() {
    DicomImage plain, implicit;
    plain.pixels.assign(12, 300);
    implicit = plain;
    implicit.implicitVr = true;
    implicit.preamble = false;
    return {dicomBytes(plain), dicomBytes(implicit)};
}

} // namespace

const std::vector<FuzzedReader>& fuzzedReaders() {
    static const std::vector<FuzzedReader> all = {{"zarr3", readZarr3, zarr3Seeds},
                                                  {"zarr2", readZarr2, zarr2Seeds},
                                                  {"ome-zarr", readOmeZarr, omeSeeds},
                                                  {"store", readGroup, groupSeeds},
                                                  {"shard", readIndex, indexSeeds},
                                                  {"chunk", readChunk, chunkSeeds},
                                                  {"dct", readDct, dctSeeds},
                                                  {"nrrd", readFile<kNrrd>, nrrdSeeds},
                                                  {"metaimage", readFile<kMeta>, metaSeeds},
                                                  {"vti", readFile<kVti>, vtiSeeds},
                                                  {"nifti", readFile<kNifti>, niftiSeeds},
                                                  {"picture", readPicture, pictureSeeds},
                                                  {"raw", readRaw, rawSeeds},
                                                  {"dicom", readFile<kDicom>, dicomSeeds},
                                                  {"scene", readScene, sceneSeeds},
                                                  {"path", readPath, pathSeeds},
                                                  {"preset", readPreset, presetSeeds},
                                                  {"hdf5", readHdf5, hdf5Seeds}};
    return all;
}

} // namespace tessera::test
