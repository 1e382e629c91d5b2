// viewer/annotations/figure.cpp: see figure.h.
#include "viewer/annotations/figure.h"

#include <algorithm>

namespace tessera {

bool Figure::any() const {
    return std::any_of(parts.begin(), parts.end(),
                       [](const FigurePart& part) { return part.annotations.any(); });
}

} // namespace tessera
