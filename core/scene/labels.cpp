// core/scene/labels.cpp: see labels.h.
#include "core/scene/labels.h"

#include <algorithm>

namespace tessera {

std::size_t opticsOf(const Labels& labels, std::size_t rule) {
    const LabelRule& asked = labels.each.at(rule);
    if (!asked.hasOptics())
        return 0;
    const auto same = [&](const LabelRule& other) {
        return other.transferFunction == asked.transferFunction && other.material == asked.material;
    };
    return 1 + static_cast<std::size_t>(std::find_if(labels.each.begin(), labels.each.end(), same) -
                                        labels.each.begin());
}

} // namespace tessera
