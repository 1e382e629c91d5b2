// viewer/cli/batch/batch_rows.cpp: see batch_rows.h.
#include "viewer/cli/batch/batch_rows.h"

#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/names.h"
#include "core/base/output_file.h"
#include "core/scene/annotations.h" // kPhasePlace
#include "core/scene/preset.h"
#include "core/scene/scene_fields.h" // setSceneKey
#include "viewer/cli/options/scene_options.h"
#include "viewer/cli/render/picture_files.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <variant>

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Makes paths absolute.
void placePaths(Scene& scene, const fs::path& folder) {
    const auto place = [&](fs::path& path) {
        if (!path.empty() && path != Labels::kTotalSegmentator)
            path = absolutePlace(folder, path);
    };
    for (SceneVolume& volume : scene.volumes) {
        place(volume.path);
        place(volume.labels.path);
        place(volume.labels.names);
    }
    for (SceneMesh& mesh : scene.meshes)
        place(mesh.path);
    if (auto& sky = scene.lighting.environment; sky && !sky->file.path.empty())
        sky->file.path = fs::absolute(folder / sky->file.path).lexically_normal();
}

/// "--series" and "--phase" choose the scene's first volume, as they do on the command line; else keyNamed().
std::string keyOfColumn(const std::string& name) {
    return name == "--series" || name == "--phase" ? "volumes[0]." + name.substr(2) : keyNamed(name);
}

} // namespace

BatchRows::BatchRows(const CsvTable& table, const Scene& scene, const std::string& pattern)
    : table_(table), scene_(scene), output_(pattern, table.names()) {
    placePaths(scene_, fs::current_path());
    const auto add = [&](const std::string& text, const std::string& key) {
        TextPattern found(text, table.names(), key, {kPhasePlace});
        if (found.hasPlaces() || found.begin() != text)
            texts_.push_back({std::move(found), key});
    };
    add(scene.annotations.title, "annotations.title");
    add(scene.annotations.caption, "annotations.caption");
    for (std::size_t n = 0; n < scene.annotations.arrows.size(); ++n)
        add(scene.annotations.arrows[n].text, "annotations.arrows[" + std::to_string(n) + "].text");

    const std::vector<std::string>& names = table.names();
    for (std::size_t n = 0; n < names.size(); ++n) {
        columns_.push_back({keyOfColumn(names[n])});
        const bool isUsed =
            output_.uses(n) || names[n] == "id" ||
            std::ranges::any_of(texts_, [&](const Text& text) { return text.pattern.uses(n); });
        if (columns_.back().key.empty() && !isUsed && !names[n].starts_with('#'))
            throw badFile(table.path().string(),
                          "columns that are keys of the scene, options that set one, names in -o or in "
                          "the scene's texts, or begin with #, which are left out",
                          "\"" + names[n].substr(0, 60) + "\"" + keyHint(names[n]));
    }
    const auto givesVolume = [](const Column& column) {
        return column.key == "volumes" || column.key == "volumes[0]" || column.key == "volumes[0].path";
    };
    if (scene.volumes.front().path.empty() && std::ranges::none_of(columns_, givesVolume))
        throw badFile(table.path().string(), "a volume (--scene, or a column \"volumes[0].path\")", "none");
    for (std::size_t n = 0; n < columns_.size(); ++n)
        for (std::size_t before = 0; before < n; ++before)
            if (!columns_[n].key.empty() && columns_[n].key == columns_[before].key)
                throw badFile(table.path().string(), "one column for a key",
                              "\"" + names[before] + "\" and \"" + names[n] + "\", which are both " +
                                  columns_[n].key);
}

BatchRow BatchRows::named(std::size_t number, const std::vector<std::string>& cells) const {
    BatchRow row;
    row.number = number;
    row.place = table_.placeOf(number);
    row.output = output_.fill(cells, number, row.place + " (for -o)");
    checkFigureName(row.output);
    const auto id = std::ranges::find(table_.names(), "id");
    row.id = id != table_.names().end() ? cells[static_cast<std::size_t>(id - table_.names().begin())]
                                        : row.output.stem().string();
    return row;
}

BatchRow BatchRows::named(std::size_t number) const {
    return named(number, table_.cells(number));
}

BatchRow BatchRows::row(std::size_t number) const {
    const std::vector<std::string> cells = table_.cells(number);
    BatchRow row = named(number, cells);
    row.scene = scene_;
    for (const Text& text : texts_)
        setSceneKey(row.scene, text.key, text.pattern.fill(cells, number), row.place + " (" + text.key + ")");
    for (std::size_t n = 0; n < columns_.size(); ++n)
        if (!columns_[n].key.empty() && !cells[n].empty())
            setKeyFromText(row.scene, columns_[n].key, cells[n],
                           row.place + " (" + table_.names()[n].substr(0, 60) + ")");
    placePaths(row.scene, table_.path().parent_path());
    static const std::vector<std::string> presets = presetNames();
    for (const SceneVolume& volume : row.scene.volumes)
        if (const auto* const name = std::get_if<std::string>(&volume.transferFunction);
            name && !name->empty() && !std::ranges::count(presets, *name))
            throw badFile(row.place + " (transferFunction)", "one of " + joinNames(presets),
                          "\"" + name->substr(0, 60) + "\"");
    if (row.scene.volumes.empty() || row.scene.volumes.front().path.empty())
        throw badFile(row.place, "a volume (--scene, or a column \"volumes[0].path\")", "none");
    return row;
}

glm::ivec2 BatchRows::largestSize() const {
    glm::ivec2 largest = scene_.imageSize;
    for (std::size_t column = 0; column < columns_.size(); ++column) {
        if (!columns_[column].key.starts_with("image"))
            continue;
        for (std::size_t n = 0; n < size(); ++n) {
            Scene alone;
            try {
                setKeyFromText(alone, columns_[column].key, table_.cells(n)[column], "");
                largest = glm::max(largest, alone.imageSize);
            } catch (const InputError&) {
                checkInterrupted(); // the row says so itself
            }
        }
    }
    return largest;
}

void BatchRows::requireDistinctOutputs(const fs::path& record, MemoryBudget& ram) const {
    struct Output {
        std::uint64_t hash;
        std::uint64_t row;
    };
    const Charge charge = ram.charge(size() * sizeof(Output), "the names of all outputs");
    std::vector<Output> outputs;
    outputs.reserve(size());
    for (std::size_t n = 0; n < size(); ++n) {
        checkInterrupted();
        const BatchRow row = named(n);
        std::error_code ignored;
        if (!record.empty() && fs::is_symlink(row.output, ignored) &&
            fs::absolute(outputTarget(row.output)).lexically_normal() == record)
            throw badFile(row.place, "an output of its own",
                          row.output.string() + ", which leads to that of --report");
        outputs.push_back({std::hash<std::string>()(row.output.lexically_normal().string()), n});
    }
    std::ranges::sort(outputs, [](const Output& a, const Output& b) {
        return a.hash != b.hash ? a.hash < b.hash : a.row < b.row;
    });
    for (std::size_t n = 1; n < outputs.size(); ++n)
        for (std::size_t before = n; before-- > 0 && outputs[before].hash == outputs[n].hash;) {
            const BatchRow a = named(outputs[before].row), b = named(outputs[n].row);
            if (a.output.lexically_normal() == b.output.lexically_normal())
                throw badFile(b.place, "an output of its own",
                              a.output.string() + ", which is also that of " + a.place);
        }
}

} // namespace tessera
