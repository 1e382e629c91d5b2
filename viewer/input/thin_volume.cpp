// viewer/input/thin_volume.cpp: see thin_volume.h.
#include "viewer/input/thin_volume.h"

#include "core/error.h"

#include <variant>

namespace tessera {
namespace {

/// The patient axis that a view looks along: 0 left-right, 1 front-back, 2 head-feet.
int axisOf(View view) {
    switch (view) {
    case View::left:
    case View::right:
        return 0;
    case View::anterior:
    case View::posterior:
        return 1;
    default:
        return 2;
    }
}

} // namespace

void requireFacingView(const Scene& scene, const VolumeInfo& info, const std::string& where) {
    const auto* fitted = std::get_if<FittedView>(&scene.camera);
    if (!fitted || (scene.mode == Mode::slice && !fitted->named))
        return;
    int thin = -1, thinAxes = 0;
    for (int axis = 0; axis < 3; ++axis)
        if (info.extentVoxels[axis] == 1)
            thin = axis, ++thinAxes;
    if (thinAxes != 1 || axisOf(fitted->view) == thin)
        return;
    const char* const faces[] = {"left", "anterior", "superior"};
    throw badFile(where, "several slices to be drawn from the side",
                  std::string("one slice, which is a line from there; --view ") + faces[thin] +
                      " faces it, and a folder gives its whole series");
}

} // namespace tessera
