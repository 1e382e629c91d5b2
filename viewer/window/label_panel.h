// viewer/window/label_panel.h: the panel of the labels beside a volume: which of them show, and how.
#pragma once

#include "viewer/window/window_state.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// Shows these labels and nothing else; all again where they already are alone.
/// @param numbers  in VolumeSeen::labels, at least one
void showAlone(WindowState& desk, LabelNumbers numbers);
/// The same of the labels at a picked place; says so where there are none.
void showAlone(WindowState& desk, const PickedPlace& picked);
/// "liver, tumour": the labels at a picked place; "" none.
std::string labelNames(const VolumeSeen& volume, const PickedPlace& picked);

class LabelPanel {
  public:
    /// Call it where the volume has labels.
    void draw(WindowState& desk);
    /// Keeps nothing of them.
    void forget();

  private:
    struct Group {
        std::string name; // "" without one
        std::vector<std::size_t> numbers;
        bool open = true, absent = false; // absent: labels without a voxel
    };
    struct Row {
        std::size_t group = 0;
        const std::size_t* number = nullptr; // in the group; null: its header
    };
    void take(const WindowState& desk);
    void findRows();
    void either(WindowState& desk);
    void all(WindowState& desk);
    void inSlices(WindowState& desk);
    void list(WindowState& desk);
    void header(WindowState& desk, Group& group);
    void label(WindowState& desk, std::size_t number);
    void eye(WindowState& desk, LabelNumbers numbers);
    void swatch(LabelNumbers numbers, const std::string& name);
    void alone(WindowState& desk, LabelNumbers numbers);
    void name(const std::string& words, bool faint, bool hasButton, const std::string& more);
    void look(WindowState& desk);

    std::shared_ptr<const LabelList> of_; // the list that the rest is of
    Labels labels_;                       // that states_ are of
    std::vector<LabelState> states_;
    std::vector<Group> groups_;
    std::vector<Row> rows_; // that the list shows
    char search_[64] = {};
    bool another_ = false;          // rows have to be found again
    bool opensLook_ = false;        // the popup, in this frame
    std::vector<std::size_t> look_; // the labels of the popup
    std::string lookName_;
};

} // namespace tessera
