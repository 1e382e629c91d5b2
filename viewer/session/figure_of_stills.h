// viewer/session/figure_of_stills.h: a figure whose panels are stills of several viewings. Each draws its
// own; the one that is done last writes the file.
#pragma once

#include "core/base/budget.h"
#include "viewer/annotations/figure.h"

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace tessera {

struct ShownPicture;

/// A picture of a figure that is saved, and what is drawn into it.
struct SavedPanel {
    std::shared_ptr<const ShownPicture> picture;
    FigurePart marks;
};

/// Thread-safe.
class FigureOfStills {
  public:
    explicit FigureOfStills(std::size_t panels) : panels_(panels), charges_(panels) {}

    /// Puts a panel. With all of them there, calls write(std::vector<SavedPanel>) under the lock, and returns
    /// true. Nothing happens once the figure is given up.
    /// @param charge  for the picture, held until the figure is written or given up
    template <typename Write>
    bool put(std::size_t panel, SavedPanel saved, Charge charge, const Write& write) {
        const std::lock_guard lock(mutex_);
        if (isOver_)
            return false;
        panels_[panel] = std::move(saved);
        charges_[panel] = std::move(charge);
        if (++there_ < panels_.size())
            return false;
        const Over over(*this);
        write(std::as_const(panels_));
        return true;
    }
    /// Drops what is there: a panel cannot be drawn, or its volume is closed.
    void giveUp() {
        const std::lock_guard lock(mutex_);
        const Over over(*this);
    }

  private:
    struct Over {
        explicit Over(FigureOfStills& of) : figure(of) {}
        Over(const Over&) = delete;
        Over& operator=(const Over&) = delete;
        ~Over() {
            figure.isOver_ = true;
            figure.panels_.clear();
            figure.charges_.clear();
        }
        FigureOfStills& figure;
    };
    std::mutex mutex_;
    std::vector<SavedPanel> panels_;
    std::vector<Charge> charges_;
    std::size_t there_ = 0;
    bool isOver_ = false;
};

/// A viewing's part in such a figure; gives the figure up when it dies before the panel is there. Empty: the
/// still is a picture of its own.
class PanelOfStills {
  public:
    PanelOfStills() = default;
    PanelOfStills(std::shared_ptr<FigureOfStills> figure, std::size_t panel)
        : figure_(std::move(figure)), panel_(panel) {}
    PanelOfStills(PanelOfStills&&) noexcept = default;
    PanelOfStills& operator=(PanelOfStills&& other) noexcept {
        if (figure_ && this != &other)
            figure_->giveUp();
        figure_ = std::move(other.figure_);
        panel_ = other.panel_;
        return *this;
    }
    ~PanelOfStills() {
        if (figure_)
            figure_->giveUp();
    }
    explicit operator bool() const { return figure_ != nullptr; }
    /// FigureOfStills::put(). This must outlive the figure's other panels, or the figure is given up.
    template <typename Write> bool put(SavedPanel saved, Charge charge, const Write& write) {
        return figure_->put(panel_, std::move(saved), std::move(charge), write);
    }

  private:
    std::shared_ptr<FigureOfStills> figure_;
    std::size_t panel_ = 0;
};

} // namespace tessera
