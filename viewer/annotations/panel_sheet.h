// viewer/annotations/panel_sheet.h: figures of several panels: where panels of one size lie, the words that
// they share, and the sheet that pictures are put on. Manifests say the same ("figure").
#pragma once

#include "core/image/image.h"
#include "viewer/annotations/figure.h"

#include <cstddef>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

class MemoryBudget;

/// Of a figure.
constexpr std::size_t kMostPanels = 400;

/// Where panels of one size lie: row by row from the upper left.
struct PanelGrid {
    int panels = 0, columns = 1, gap = 0; // pixels between neighbours
    glm::ivec2 panelSize{0};
    Strips strips = {};       // around each
    int above = 0, below = 0; // pixels of the title's and the caption's strips, of all panels

    int rows() const { return (panels + columns - 1) / columns; }
    glm::ivec2 size() const;
    /// Of a panel with its strips.
    glm::ivec2 cellSize() const { return panelSize + strips.size(); }
    /// Upper left corner of a panel with its strips.
    glm::ivec2 at(int panel) const;
};
/// @param columns  0: up to three stand in a row, more in a grid that is about square
/// @param where  in messages
/// Throws InputError naming where for a figure with longer sides than pictures have.
PanelGrid gridOf(int panels, int columns, int gap, const glm::ivec2& panelSize, const std::string& where);
/// Throws InputError naming where for a figure, with its strips of words, of longer sides than pictures have.
void checkSize(const PanelGrid& grid, const std::string& where);

/// What the panels of a figure share.
struct PanelLayout {
    PanelGrid grid;
    Annotations words; // the title and the caption of all panels, and their size
    bool oneScale = true;
    bool letters = false; // A, B, C in the corners of panels
};

/// Words that all panels have stand once, above and below all of them: takes them from the panels. At least
/// one.
Annotations takeShared(const std::vector<Annotations*>& panels);
/// Sets the strips above and below the panels by the shared words. Throws as checkSize() does.
void makeRoomForWords(PanelLayout& layout, const std::string& where);

/// RAM that the figure takes while its panels are drawn.
std::size_t bytesOf(const PanelGrid& grid);

/// The manifest's "figure".
nlohmann::json layoutJson(const PanelLayout& layout);
/// The layout of one. Throws InputError naming where.
PanelLayout layoutOfJson(const nlohmann::json& said, int panels, const std::string& where);

/// The figure while its panels are drawn.
class PanelSheet {
  public:
    /// The caller has charged bytesOf().
    explicit PanelSheet(const PanelLayout& layout);
    /// Of every panel.
    const Strips& strips() const { return layout_.grid.strips; }
    /// Puts the next panel, from the upper left.
    /// @param picture  of the size of a panel
    /// @param part  what is drawn over it; its box and strips are set here
    /// @param background  linear; none: transparent. That of the first panel also lies between panels, or the
    ///                    colour of its strips
    void put(const Image& picture, FigurePart part, const std::optional<glm::vec3>& background,
             nlohmann::json manifest);
    /// Writes the figure with the manifest that it returns. After all panels. Throws as writeFigure() does.
    nlohmann::json write(const std::filesystem::path& path, MemoryBudget& ram);

  private:
    void fillRest();

    PanelLayout layout_;
    Image image_;
    Figure figure_;
    glm::vec4 between_{0}; // linear, premultiplied
    nlohmann::json panels_ = nlohmann::json::array();
};

} // namespace tessera
