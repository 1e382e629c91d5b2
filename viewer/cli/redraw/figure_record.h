// viewer/cli/redraw/figure_record.h: a picture's own record, as what draws it again: its scene, its data and
// its options. Include from .cpp files only.
#pragma once

#include "core/animation/path.h"
#include "core/scene/scene.h"
#include "viewer/cli/manifest/picture_data.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct FigureRecord {
    std::filesystem::path figure;
    nlohmann::json manifest;
    Scene scene; // its paths stand for data and lead nowhere
    std::vector<PictureData> data;
    std::vector<SourceChoice> sources; // what was chosen among source files, of each volume
    std::size_t ramBytes = 0, gpuBytes = 0;
    std::string lineHash;     // of a picture along a line: an unfolded wall or a reformation
    std::optional<Path> path; // of such a picture
};

/// A picture's own, or those of the panels of a figure. Throws InputError naming the file: for one that is no
/// picture of this program, and for a manifest that cannot be understood.
std::vector<FigureRecord> readFigure(const std::filesystem::path& figure);

/// The manifest of a picture that was just drawn.
nlohmann::json manifestJsonOf(const std::filesystem::path& picture);

/// What draws it: engine, verification, tiles, layers and budgets as they were. Without input and output.
/// Throws InputError naming the figure for options that no picture has, and for a picture along a line whose
/// path is not known.
RenderArguments argumentsOf(const FigureRecord& record);

/// True of an unfolded wall and of a reformation.
bool isAlongLine(const nlohmann::json& manifest);
/// The digest of the line that a picture lies along; "": it lies along none.
std::string lineHashOf(const nlohmann::json& manifest);

/// The measurement that a manifest tells of: "quick".
std::string verifyOfManifest(const nlohmann::json& manifest);

} // namespace tessera
