// bricking/import/part_facts.cpp: see part_facts.h.
#include "bricking/import/part_facts.h"

#include "bricking/store/checked_json.h"
#include "bricking/store/shard.h"
#include "bricking/store/store_files.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr char kFacts[] = "part.json";
constexpr std::uint64_t kMostFactBytes = 16u << 20;
constexpr int kFactsVersion = 1;
constexpr std::int64_t kMostCount = std::numeric_limits<std::int64_t>::max();
const std::string kRoot = "/attributes/tessera"; // where seal() puts the checksum

/// What a part must say, equal for every process.
Json identityOf(const PartsOfImport& all, int part) {
    const glm::ivec3 e = all.info.extentVoxels;
    return {{"version", kFactsVersion},
            {"key", all.key},
            {"extentVoxels", Json::array({e.x, e.y, e.z})},
            {"valueType", name(all.info.type)},
            {"firstSlice", all.parts.first(part)},
            {"slices", all.parts.slicesOf(part)}};
}

Json jsonOf(const ShardFile& file) {
    return Json::array({file.level, file.at.x, file.at.y, file.at.z, file.bytes, file.record.chunks,
                        file.record.indexCrc, file.record.payloadCrc});
}

Json jsonOf(const LabelTally& labels) {
    return {{"values", labels.values},
            {"isOther", labels.isOther},
            {"voxels", labels.voxels},
            {"inside", labels.inside},
            {"edges", labels.edges}};
}

/// Access to one document.
struct FactsReader {
    const Json& document;
    const std::string& where;
    std::uint64_t count(const std::string& key, std::int64_t most = kMostCount) const {
        return static_cast<std::uint64_t>(integerAt(document, kRoot + key, 0, most, where));
    }
    double number(const std::string& key) const { return numberAt(document, kRoot + key, where); }
    bool flag(const std::string& key) const { return flagAt(document, kRoot + key, where); }
    std::size_t size(const std::string& key) const { return jsonAt(document, kRoot + key, where).size(); }
};

ShardFile readFile(const FactsReader& facts, std::size_t number, const VolumeInfo& info) {
    const std::string at = "/files/" + std::to_string(number) + "/";
    const auto below = [&](const char* place, std::int64_t end) {
        return static_cast<int>(facts.count(at + place, end - 1));
    };
    constexpr std::int64_t kCrcs = std::int64_t{1} << 32;
    ShardFile file;
    file.level = below("0", kLevelCount);
    const ShardLayout layout = shardLayout(levelExtent(info.extentVoxels, file.level));
    file.at = {below("1", layout.shards.x), below("2", layout.shards.y), below("3", layout.shards.z)};
    file.bytes = facts.count(at + "4");
    file.record.chunks =
        static_cast<std::uint32_t>(facts.count(at + "5", static_cast<std::int64_t>(layout.entries())));
    file.record.indexCrc = static_cast<std::uint32_t>(facts.count(at + "6", kCrcs - 1));
    file.record.payloadCrc = static_cast<std::uint32_t>(facts.count(at + "7", kCrcs - 1));
    return file;
}

PartFacts parseFacts(const Json& document, const PartsOfImport& all, const std::string& where) {
    const FactsReader read{document, where};
    PartFacts facts;
    WrittenPart& written = facts.written;
    written.levels.lowest = read.number("/lowest");
    written.levels.highest = read.number("/highest");
    written.levels.chunksWritten = read.count("/chunksWritten");
    written.levels.chunksFill = read.count("/chunksFill");
    for (std::size_t i = 0; i < read.size("/files"); ++i)
        written.levels.files.push_back(readFile(read, i, all.info));
    written.restBytes = read.count("/restBytes");
    written.restCrc =
        static_cast<std::uint32_t>(read.count("/restCrc", std::numeric_limits<std::uint32_t>::max()));
    facts.bytesIn = read.count("/bytesIn");
    VoxelFindings& found = facts.findings;
    found.nonFiniteVoxels = read.count("/nonFiniteVoxels");
    found.absentStored = read.number("/absentStored");
    found.clampedVoxels = read.count("/clampedVoxels");
    found.lossy = read.flag("/lossy");
    RoundingTally& rounded = found.tally.rounded;
    rounded.whole = read.count("/rounded/whole");
    rounded.real = read.count("/rounded/real");
    rounded.most = read.number("/rounded/most");
    rounded.mostPart = read.number("/rounded/mostPart");
    LabelTally& labels = found.tally.labels;
    for (std::size_t i = 0; i < read.size("/labels/values"); ++i)
        labels.values.push_back(read.number("/labels/values/" + std::to_string(i)));
    labels.isOther = read.flag("/labels/isOther");
    labels.voxels = read.count("/labels/voxels");
    labels.inside = read.count("/labels/inside");
    labels.edges = read.count("/labels/edges");
    for (std::size_t i = 0; i < read.size("/notes"); ++i)
        found.notes.push_back(textAt(document, kRoot + "/notes/" + std::to_string(i), where));
    return facts;
}

} // namespace

void VoxelFindings::add(const VoxelFindings& part) {
    if (nonFiniteVoxels == 0)
        absentStored = part.absentStored;
    nonFiniteVoxels += part.nonFiniteVoxels;
    clampedVoxels += part.clampedVoxels;
    lossy = lossy || part.lossy;
    tally.add(part.tally);
    for (const std::string& note : part.notes)
        if (std::ranges::find(notes, note) == notes.end())
            notes.push_back(note);
}

VolumeInfo VoxelFindings::applied(VolumeInfo info) const {
    if (info.nonFiniteVoxels == 0 && nonFiniteVoxels > 0)
        info.absentStored = absentStored;
    info.nonFiniteVoxels += nonFiniteVoxels;
    info.clampedVoxels += clampedVoxels;
    info.lossy = info.lossy || lossy;
    if (std::string remark = tally.labels.remark(); !remark.empty())
        info.remarks.push_back(std::move(remark));
    return info;
}

void writePartFacts(const fs::path& folder, const PartsOfImport& all, int part, const PartFacts& facts) {
    const WrittenLevels& levels = facts.written.levels;
    const VoxelFindings& found = facts.findings;
    Json json = identityOf(all, part);
    json["lowest"] = levels.lowest;
    json["highest"] = levels.highest;
    json["chunksWritten"] = levels.chunksWritten;
    json["chunksFill"] = levels.chunksFill;
    json["files"] = Json::array();
    for (const ShardFile& file : levels.files)
        json["files"].push_back(jsonOf(file));
    json["restBytes"] = facts.written.restBytes;
    json["restCrc"] = facts.written.restCrc;
    json["bytesIn"] = facts.bytesIn;
    json["nonFiniteVoxels"] = found.nonFiniteVoxels;
    json["absentStored"] = found.absentStored;
    json["clampedVoxels"] = found.clampedVoxels;
    json["lossy"] = found.lossy;
    const RoundingTally& rounded = found.tally.rounded;
    json["rounded"] = {{"whole", rounded.whole},
                       {"real", rounded.real},
                       {"most", rounded.most},
                       {"mostPart", rounded.mostPart}};
    json["labels"] = jsonOf(found.tally.labels);
    json["notes"] = Json::array();
    for (const std::string& note : found.notes)
        json["notes"].push_back(printable(note));
    Json document = {{"attributes", {{"tessera", json}}}};
    seal(document);
    writeFile(folder / kFacts, storedText(document));
}

std::optional<PartFacts> readPartFacts(const fs::path& folder, const PartsOfImport& all, int part,
                                       const fs::path& store) {
    std::error_code ignored;
    if (!fs::is_directory(folder, ignored))
        return std::nullopt;
    try {
        const std::string where = (folder / kFacts).string();
        const auto text = readText(openFolder(folder), kFacts, folder, kMostFactBytes);
        if (!text)
            return std::nullopt;
        const Json document = parseJson(*text, where);
        checkSeal(document, where);
        const Json identity = identityOf(all, part);
        for (const auto& [key, value] : identity.items())
            if (jsonAt(document, kRoot + "/" + key, where) != value)
                return std::nullopt;
        PartFacts facts = parseFacts(document, all, where);
        if (!isWhole({folder, facts.written}, store))
            return std::nullopt;
        return facts;
    } catch (const InputError&) { // damaged
        return std::nullopt;
    }
}

} // namespace tessera
