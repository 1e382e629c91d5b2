// bricking/labels/label_files.cpp: see label_files.h.
#include "bricking/labels/label_files.h"

#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_array.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t kLabelsVersion = 1;
constexpr int kArrayChunk = 1 << 18;                                   // values
constexpr std::uint64_t kMostValues = std::numeric_limits<int>::max(); // of an array
constexpr std::uint64_t kMaxTableBytes = 64u << 20;
constexpr std::size_t kJsonBytesPerByte = 24; // of text, while it is parsed and its checksum is found
constexpr int kMaxTableDepth = 16;
constexpr const char* kSets = "sets";

ArraySpec arraySpec(std::uint64_t values) {
    return {"uint16", 2, {1, 1, static_cast<int>(values)}, {1, 1, kArrayChunk}, 0};
}

/// Voxels of a cell that are in the volume.
std::uint32_t voxelsOf(const glm::ivec3& cell, const glm::ivec3& extent) {
    const glm::ivec3 size = glm::min(extent - cell * kCellExtent, glm::ivec3(kCellExtent));
    return static_cast<std::uint32_t>(size.x * size.y * size.z);
}

Json tableJson(const LabelTable& table) {
    Json labels = Json::array(), sets = Json::array();
    for (const Label& label : table.labels) {
        Json row = {{"value", label.value}, {"name", label.name}};
        if (!label.group.empty())
            row["group"] = label.group;
        if (label.colour)
            row["colour"] = Json::array({label.colour->x, label.colour->y, label.colour->z});
        labels.push_back(row);
    }
    for (const auto& set : table.sets)
        sets.push_back(Json(set));
    return {{"labels", labels}, {"sets", sets}};
}

/// Reads the table of an about-object; every refusal names `where`.
class TableReader {
  public:
    explicit TableReader(std::string where) : where_(std::move(where)) {}

    LabelTable read(const Json& about) const {
        LabelTable table;
        for (const Json& row : listAt(about, "labels"))
            table.labels.push_back(labelOf(row, table.labels));
        table.sets.clear();
        for (const Json& row : listAt(about, "sets"))
            table.sets.push_back(setOf(row, table));
        if (table.sets.empty())
            refuse("sets, the first of them empty", "none");
        return table;
    }

  private:
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(where_, expected, found);
    }
    const Json& listAt(const Json& about, const char* key) const {
        if (!about.contains(key) || !about.at(key).is_array())
            refuse(std::string("a list of ") + key, "none");
        if (about.at(key).size() > LabelTable::kMostSets)
            refuse("at most " + std::to_string(LabelTable::kMostSets) + " " + key,
                   std::to_string(about.at(key).size()));
        return about.at(key);
    }
    Label labelOf(const Json& row, const std::vector<Label>& before) const {
        Label label;
        const auto textOf = [&](const char* key) {
            return row.at(key).is_string() ? row.at(key).get<std::string>() : std::string();
        };
        const auto isText = [&](const char* key) { return row.contains(key) && !textOf(key).empty(); };
        if (!row.is_object() || !row.contains("value") || !row.at("value").is_number_unsigned() ||
            !isText("name") || (row.contains("group") && !isText("group")))
            refuse("labels with a value and a name", "something else");
        const auto value = row.at("value").get<std::uint64_t>();
        if (value == 0 || value > UINT32_MAX || (!before.empty() && value <= before.back().value))
            refuse("labels by ascending value, from 1 to 4294967295", std::to_string(value));
        label.value = static_cast<std::uint32_t>(value);
        label.name = textOf("name");
        if (row.contains("group"))
            label.group = textOf("group");
        if (row.contains("colour")) {
            const Json& colour = row.at("colour");
            label.colour.emplace();
            for (std::size_t i = 0; i < 3; ++i) {
                if (!colour.is_array() || colour.size() != 3 || !colour[i].is_number() ||
                    !(colour[i].get<double>() >= 0 && colour[i].get<double>() <= 1))
                    refuse("a colour of three numbers from 0 to 1", "something else");
                (*label.colour)[static_cast<int>(i)] = colour[i].get<float>();
            }
        }
        return label;
    }
    std::vector<std::uint16_t> setOf(const Json& row, const LabelTable& table) const {
        std::vector<std::uint16_t> set;
        if (!row.is_array() || row.empty() != table.sets.empty())
            refuse("sets of labels, the first alone empty", "something else");
        for (const Json& number : row) {
            if (!number.is_number_unsigned() || number.get<std::uint64_t>() >= table.labels.size() ||
                (!set.empty() && number.get<std::uint64_t>() <= set.back()))
                refuse("sets of ascending numbers of labels", "something else");
            set.push_back(number.get<std::uint16_t>());
        }
        if (!table.sets.empty() && !comesBefore(table.sets.back(), set))
            refuse("sets by size, then by their labels", "another order");
        return set;
    }

    std::string where_;
};

void checkDepth(const std::string& text, const std::string& where) {
    int depth = 0;
    bool isQuoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (isQuoted && c == '\\')
            ++i;
        else if (c == '"')
            isQuoted = !isQuoted;
        else if (!isQuoted && (c == '[' || c == '{') && ++depth > kMaxTableDepth)
            throw badFile(where, "a table of labels", "JSON that nests too deep");
        else if (!isQuoted && (c == ']' || c == '}'))
            --depth;
    }
}

/// The document of the group, with its checksum checked.
/// @param charge  gets the memory for it
Json readGroup(const StoreFolder& folder, const fs::path& store, const std::string& where, MemoryBudget& ram,
               Charge& charge) {
    const std::string name = std::string(kSets) + "/zarr.json";
    const auto file = openIn(folder, name, store);
    if (!file)
        throw badFile(where, "the table of a volume of labels", "no such file");
    const std::uint64_t bytes = fileSize(*file, where);
    if (bytes > kMaxTableBytes)
        throw badFile(where, "at most 64 MiB", formatBytes(bytes));
    charge = ram.charge(static_cast<std::size_t>(bytes) * kJsonBytesPerByte, "the table of labels");
    const auto text = readText(folder, name, store, kMaxTableBytes);
    if (!text || text->size() > bytes)
        throw badFile(where, "a file that nothing changes", "one that grew");
    checkDepth(*text, where);
    Json document = parseJson(*text, where);
    if (!document.is_object() || !document.contains("attributes") || !document.at("attributes").is_object())
        throw badFile(where, "the table of a volume of labels", "other JSON");
    checkSeal(document, where);
    return document;
}

/// An array, piece by piece from its start.
class ArrayReader {
  public:
    ArrayReader(const StoreFolder& folder, const fs::path& store, const char* name, std::uint64_t values)
        : folder_(folder), store_(store), relative_(std::string(kSets) + "/" + name),
          spec_(arraySpec(values)), values_(values), kept_(kArrayChunk) {
        checkArrayMetadata(folder_, relative_, spec_, store_);
    }
    std::string where() const { return (store_ / relative_).string(); }
    std::uint16_t next() {
        if (at_ == values_)
            throw badFile(where(), std::to_string(values_) + " values, as its group says", "more in use");
        const auto in = static_cast<std::size_t>(at_ % kArrayChunk);
        if (in == 0) {
            const auto count = std::min<std::uint64_t>(kArrayChunk, values_ - at_);
            const auto bytes =
                std::as_writable_bytes(std::span(kept_).first(static_cast<std::size_t>(count)));
            readArrayLayer(folder_, relative_, spec_, static_cast<int>(at_ / kArrayChunk), bytes, store_);
            crc_ = crc32c(bytes, crc_);
        }
        ++at_;
        return kept_[in];
    }
    void requireEnd(std::uint32_t crc) const {
        if (at_ != values_)
            throw badFile(where(), std::to_string(at_) + " values in use", std::to_string(values_));
        if (crc_ != crc)
            throw badFile(where(), "the array that its group describes", "another");
    }

  private:
    const StoreFolder& folder_;
    const fs::path& store_;
    std::string relative_;
    ArraySpec spec_;
    std::uint64_t values_, at_ = 0;
    std::uint32_t crc_ = 0;
    std::vector<std::uint16_t> kept_;
};

struct ArraysOf {
    std::uint64_t cells = 0, shares = 0;
    std::array<std::uint32_t, 3> crcs{};
};

/// Calls body(cell, shares) of every cell, which are checked.
void eachCell(const StoreFolder& folder, const fs::path& store, const glm::ivec3& extent,
              const ArraysOf& arrays, std::size_t sets,
              const std::function<void(std::size_t, std::span<const LabelCells::Share>)>& body) {
    ArrayReader counts(folder, store, "counts", arrays.cells), set(folder, store, "set", arrays.shares),
        voxels(folder, store, "voxels", arrays.shares);
    const glm::ivec3 grid = cellGrid(extent);
    std::vector<LabelCells::Share> shares;
    std::size_t cell = 0;
    for (glm::ivec3 at(0); at.z < grid.z; ++at.z)
        for (at.y = 0; at.y < grid.y; ++at.y)
            for (at.x = 0; at.x < grid.x; ++at.x, ++cell) {
                const std::uint32_t all = voxelsOf(at, extent), count = counts.next();
                if (count == 0 || count > all)
                    throw badFile(counts.where(), "1 to " + std::to_string(all) + " sets in a cell",
                                  std::to_string(count));
                shares.clear();
                std::uint32_t sum = 0;
                for (std::uint32_t i = 0; i < count; ++i) {
                    const LabelCells::Share share{set.next(), voxels.next()};
                    if (share.set >= sets || (i > 0 && share.set <= shares.back().set))
                        throw badFile(set.where(), "ascending sets below " + std::to_string(sets),
                                      std::to_string(share.set));
                    if (share.voxels == 0)
                        throw badFile(voxels.where(), "at least one voxel of every set", "none");
                    sum += share.voxels;
                    shares.push_back(share);
                }
                if (sum != all)
                    throw badFile(voxels.where(), std::to_string(all) + " voxels in a cell",
                                  std::to_string(sum));
                body(cell, shares);
            }
    counts.requireEnd(arrays.crcs[0]);
    set.requireEnd(arrays.crcs[1]);
    voxels.requireEnd(arrays.crcs[2]);
}

/// The shares of one cell, by ascending set.
void countCell(std::span<const std::uint16_t> numbers, const glm::ivec3& size, const glm::ivec3& cell,
               std::vector<std::uint16_t>& counts, std::vector<std::uint16_t>& sets,
               std::vector<std::uint16_t>& voxels) {
    std::array<std::uint16_t, kCellExtent * kCellExtent * kCellExtent> found;
    std::size_t n = 0;
    const glm::ivec3 first = cell * kCellExtent, end = glm::min(first + kCellExtent, size);
    for (int z = first.z; z < end.z; ++z)
        for (int y = first.y; y < end.y; ++y) {
            const auto* row = numbers.data() + linearIndex({first.x, y, z}, size);
            for (int x = 0; x < end.x - first.x; ++x)
                found[n++] = row[x];
        }
    const auto used = std::span(found).first(n);
    if (!std::all_of(used.begin(), used.end(), [&](std::uint16_t v) { return v == used[0]; }))
        std::sort(used.begin(), used.end());
    std::uint16_t count = 0;
    for (std::size_t at = 0; at < n; ++count) {
        const std::size_t next = static_cast<std::size_t>(
            std::upper_bound(used.begin() + static_cast<std::ptrdiff_t>(at), used.end(), used[at]) -
            used.begin());
        sets.push_back(used[at]);
        voxels.push_back(static_cast<std::uint16_t>(next - at));
        at = next;
    }
    counts.push_back(count);
}

int rowsAtOnce(int threads) {
    return threads > 0 ? threads : defaultThreads();
}

} // namespace

LabelFilesWriter::LabelFilesWriter(const fs::path& folder, const glm::ivec3& extentVoxels, int threads)
    : folder_(folder / kSets), extent_(extentVoxels), threads_(threads) {
    if (cellCount(cellGrid(extent_)) > kMostValues)
        throw InputError("labels: expected at most " + std::to_string(kMostValues) +
                         " cells of 8^3 voxels, " + "found more");
    const auto rows = static_cast<std::size_t>(rowsAtOnce(threads_));
    for (auto* of : {&rowCounts_, &rowSets_, &rowVoxels_})
        of->resize(rows);
    for (Array* array : {&counts_, &set_, &voxels_})
        array->kept.reserve(kArrayChunk);
    fs::create_directories(folder_);
}

std::size_t LabelFilesWriter::bytesNeeded(const glm::ivec3& extentVoxels, int threads) {
    const std::size_t rowVoxels = cellCount({extentVoxels.x, kCellExtent, kCellExtent});
    // A row's shares, where every voxel is one; twice, because vectors grow.
    return static_cast<std::size_t>(rowsAtOnce(threads)) * rowVoxels * 2 * 2 * sizeof(std::uint16_t) +
           3 * kArrayChunk * sizeof(std::uint16_t) + arraySpec(1).scratchBytes();
}

void LabelFilesWriter::add(std::span<const std::uint16_t> numbers, int slices) {
    TESSERA_CHECK(nextZ_ % kCellExtent == 0 && nextZ_ + slices <= extent_.z);
    const glm::ivec3 size(extent_.x, extent_.y, slices), grid = cellGrid(size);
    TESSERA_CHECK(numbers.size() == cellCount(size));
    for (int z = 0; z < grid.z; ++z)
        for (int y = 0; y < grid.y; y += static_cast<int>(rowCounts_.size())) {
            const auto rows =
                static_cast<std::size_t>(std::min(grid.y - y, static_cast<int>(rowCounts_.size())));
            parallelFor(rows, threads_, [&](std::size_t i) {
                for (auto* of : {&rowCounts_, &rowSets_, &rowVoxels_})
                    (*of)[i].clear();
                for (int x = 0; x < grid.x; ++x)
                    countCell(numbers, size, {x, y + static_cast<int>(i), z}, rowCounts_[i], rowSets_[i],
                              rowVoxels_[i]);
            });
            for (std::size_t i = 0; i < rows; ++i) {
                append(counts_, rowCounts_[i]);
                append(set_, rowSets_[i]);
                append(voxels_, rowVoxels_[i]);
            }
        }
    nextZ_ += slices;
}

void LabelFilesWriter::append(Array& array, std::span<const std::uint16_t> values) {
    array.values += values.size();
    if (array.values > kMostValues)
        throw InputError("labels: expected at most " + std::to_string(kMostValues) +
                         " shares of sets in cells of 8^3 voxels, found more");
    while (!values.empty()) {
        const std::size_t step =
            std::min(values.size(), static_cast<std::size_t>(kArrayChunk) - array.kept.size());
        array.kept.insert(array.kept.end(), values.begin(),
                          values.begin() + static_cast<std::ptrdiff_t>(step));
        values = values.subspan(step);
        if (array.kept.size() == kArrayChunk)
            flush(array);
    }
}

void LabelFilesWriter::flush(Array& array) {
    const auto bytes = std::as_bytes(std::span(std::as_const(array.kept)));
    array.crc = crc32c(bytes, array.crc);
    const auto first = static_cast<std::uint64_t>(array.layers) * kArrayChunk;
    writeArrayLayer(folder_ / array.name, arraySpec(first + array.kept.size()), array.layers++, bytes);
    array.kept.clear();
}

void LabelFilesWriter::finish(const LabelTable& table, const StoreReader& store) {
    TESSERA_CHECK(nextZ_ == extent_.z);
    for (Array* array : {&counts_, &set_, &voxels_}) {
        if (!array->kept.empty())
            flush(*array);
        writeArrayMetadata(folder_ / array->name, arraySpec(array->values));
        std::vector<std::uint16_t>().swap(array->kept);
    }
    Json group = {{"zarr_format", 3}, {"node_type", "group"}, {"attributes", Json::object()}};
    Json& about = group["attributes"]["tessera"];
    about = tableJson(table);
    about["kind"] = "labels";
    about["version"] = kLabelsVersion;
    about["store"] = store.contentHash();
    about["shares"] = set_.values;
    about["crc"] = Json::array({counts_.crc, set_.crc, voxels_.crc});
    seal(group);
    const std::string text = storedText(group);
    if (text.size() > kMaxTableBytes)
        throw InputError("labels: expected a table of names and sets of at most 64 MiB, found " +
                         formatBytes(text.size()));
    writeFile(folder_ / "zarr.json", text);
}

std::string imageLabelOf(const LabelTable& table) {
    constexpr std::size_t kMostShown = 4096; // sets
    if (table.sets.size() > kMostShown)
        return "";
    const auto encoded = [](float linear) { // sRGB, 8 bits
        const double x = linear <= 0.0031308f ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
        return static_cast<int>(std::lround(255 * x));
    };
    Json colours = Json::array(), properties = Json::array();
    for (std::size_t number = 1; number < table.sets.size(); ++number) {
        Json names = Json::array(), values = Json::array();
        glm::vec3 sum(0);
        float coloured = 0;
        for (const std::uint16_t i : table.sets[number]) {
            const Label& label = table.labels[i];
            names.push_back(label.name);
            values.push_back(label.value);
            if (label.colour) {
                sum += *label.colour;
                ++coloured;
            }
        }
        properties.push_back({{"label-value", number}, {"names", names}, {"values", values}});
        if (coloured > 0) {
            const glm::vec3 mean = sum / coloured;
            colours.push_back({{"label-value", number},
                               {"rgba", {encoded(mean.x), encoded(mean.y), encoded(mean.z), 255}}});
        }
    }
    Json shown = {{"properties", properties}};
    if (!colours.empty())
        shown["colors"] = colours;
    return shown.dump();
}

namespace {

/// The table, and what it says about the arrays.
LabelTable readTable(const StoreFolder& folder, const StoreReader& store, MemoryBudget& ram,
                     ArraysOf& arrays) {
    const std::string where = (store.path() / kSets / "zarr.json").string();
    const std::string root = "/attributes/tessera";
    Charge charge;
    const Json document = readGroup(folder, store.path(), where, ram, charge);
    integerAt(document, root + "/version", kLabelsVersion, kLabelsVersion, where);
    if (textAt(document, root + "/store", where) != store.contentHash())
        throw badFile(where, "the table of this store's labels", "that of another");
    LabelTable table = TableReader(where).read(jsonAt(document, root, where));
    arrays.cells = cellCount(cellGrid(store.info().extentVoxels));
    arrays.shares = static_cast<std::uint64_t>(
        integerAt(document, root + "/shares", 1, static_cast<std::int64_t>(kMostValues), where));
    for (std::size_t i = 0; i < 3; ++i)
        arrays.crcs[i] = static_cast<std::uint32_t>(
            integerAt(document, root + "/crc/" + std::to_string(i), 0, UINT32_MAX, where));
    const ValueType type = store.info().type, expected = labelTypeOf(table);
    if (type != expected)
        throw badFile(where, std::string("sets that ") + name(type) + " holds",
                      std::to_string(table.sets.size()));
    if (arrays.cells > kMostValues || arrays.cells > arrays.shares)
        throw badFile(where, "a share of every one of " + std::to_string(arrays.cells) + " cells",
                      std::to_string(arrays.shares));
    return table;
}

} // namespace

LabelTable readLabelTable(const StoreReader& store, MemoryBudget& ram) {
    ArraysOf arrays;
    return readTable(openFolder(store.path()), store, ram, arrays);
}

LabelFiles readLabelFiles(const StoreReader& store, MemoryBudget& ram) {
    const StoreFolder folder = openFolder(store.path());
    const glm::ivec3 extent = store.info().extentVoxels;
    LabelFiles files;
    ArraysOf arrays;
    files.table = readTable(folder, store, ram, arrays);
    const Charge scratch =
        ram.charge(3 * kArrayChunk * sizeof(std::uint16_t) + arraySpec(1).scratchBytes(), "reading labels");
    // Once for the checks; only then is what they take known to be there.
    eachCell(folder, store.path(), extent, arrays, files.table.sets.size(), [](auto, auto) {});
    LabelCells& cells = files.cells;
    cells.charge = ram.charge(static_cast<std::size_t>(arrays.cells + 1) * sizeof(std::uint32_t) +
                                  static_cast<std::size_t>(arrays.shares) * sizeof(LabelCells::Share) +
                                  bytesOf(files.table),
                              "the cells of a volume of labels");
    cells.cells = cellGrid(extent);
    cells.first.reserve(static_cast<std::size_t>(arrays.cells + 1));
    cells.shares.reserve(static_cast<std::size_t>(arrays.shares));
    cells.first.push_back(0);
    eachCell(folder, store.path(), extent, arrays, files.table.sets.size(), [&](auto, auto shares) {
        cells.shares.insert(cells.shares.end(), shares.begin(), shares.end());
        cells.first.push_back(static_cast<std::uint32_t>(cells.shares.size()));
    });
    return files;
}

} // namespace tessera
