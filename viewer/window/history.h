// viewer/window/history.h: undo and redo of scenes.
#pragma once

#include "core/scene/scene.h"

#include <cstddef>
#include <vector>

namespace tessera {

/// A continuous edit (dragging a point) is one step: call begin() once at its start.
class History {
  public:
    /// Records the scene before an edit. Clears redo.
    void begin(const Scene& before) {
        undone_.clear();
        done_.push_back(before);
        if (done_.size() > kMost)
            done_.erase(done_.begin());
    }
    bool canUndo() const { return !done_.empty(); }
    bool canRedo() const { return !undone_.empty(); }
    /// The scene before the last edit.
    /// @param now  the current scene, kept for redo()
    Scene undo(const Scene& now) { return step(done_, undone_, now); }
    Scene redo(const Scene& now) { return step(undone_, done_, now); }

  private:
    static constexpr std::size_t kMost = 200;
    static Scene step(std::vector<Scene>& from, std::vector<Scene>& to, const Scene& now) {
        if (from.empty())
            return now;
        to.push_back(now);
        Scene scene = std::move(from.back());
        from.pop_back();
        return scene;
    }
    std::vector<Scene> done_, undone_;
};

} // namespace tessera
