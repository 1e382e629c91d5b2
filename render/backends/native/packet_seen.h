// render/backends/native/packet_seen.h: the visible part of a sample beside its value: labels, gradient
// opacity and light, in the order of render/backends/mirror/mirror_sample.h, for all lanes of a packet. For
// packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_gradient.h"
#include "render/backends/native/packet_labels.h"
#include "render/backends/native/packet_optics.h"

namespace tessera::TESSERA_LANES {

using native::PacketScene;

/// Shares of light that reach p, of lanes whose gradient there has been taken: no brick is lacking.
template <bool Mixed>
TESSERA_LANE leaf::ReceivedLight<F> lightAt(const PacketScene& s, const Here<Mixed>& here, F3 p, M m) {
    const F3 x = inBrick(here, p);
    const M inside = m & isHere(here, x);
    return leaf::receivedLight<F>(s.optics.lighting, [&](int channel) {
        M there = m;
        return F(1 / leaf::kLightOne) * valueAt<SampleKind::u16>(s.light[channel], here, p, x, inside, there);
    });
}

/// Colours at p, lit as the scene is: the same as seenColour() of render/contract/optics.h, for lanes.
/// @param direction  patient space
/// @param place  of the value that is lit, in the table
template <bool Mixed>
TESSERA_LANE F3 seenColour(const PacketScene& s, const Here<Mixed>& here, F3 colour, F3 gradient,
                           F3 direction, F3 p, F place, M m) {
    const PacketOptics& o = s.optics;
    if (!o.lit)
        return colour;
    if (!o.hasLights)
        return shaded(o, colour, gradient, direction);
    if (o.lighting.channels == 0)
        return shadedByLights(o, colour, gradient, direction, p, place, leaf::AllLight());
    return shadedByLights(o, colour, gradient, direction, p, place, lightAt<Mixed>(s, here, p, m));
}

/// What colours and extinctions of samples depend on beside values.
struct Beside {
    leaf::LabelShares<F> labels;
    F medium{0.0f};   // the labels' own extinction
    F ofLabels{0.0f}; // the share of light in the labels' colour
    F3 gradient;
};

/// Takes the labels at p. Returns the lanes that show something; those that lack a brick are taken from m.
/// @param extinction  of the function
template <bool Mixed>
TESSERA_LANE M takeLabels(const PacketScene& s, const Here<Mixed>& here, F3 p, F extinction, Beside& beside,
                          M& m) {
    beside.labels = labelsAt<Mixed>(s, here, p, m);
    beside.medium = leaf::labelledMedium(beside.labels, F(s.optics.labels.density));
    const M takes = (leaf::labelledFunction(beside.labels, extinction) > F(0.0f)) | (beside.medium > F(0.0f));
    return m & takes;
}

/// Takes the gradient at p, and multiplies extinctions by gradient opacity.
/// @param adds  lanes that show something. Those that lack a brick are taken from it, and from no other than
///     the caller's lanes that it returns; so are those that show nothing.
/// @param rows  as valueHere()
template <SampleKind K, bool Mixed>
TESSERA_LANE M takeGradient(const PacketScene& s, const Here<Mixed>& here, F3 p, bool hasLabels,
                            PacketRows* rows, Beside& beside, F& extinction, M& adds,
                            std::uint64_t& gradients) {
    const PacketOptics& o = s.optics;
    const M wanted = adds;
    const bool grades = o.gradientOpacity.count > 0, smooths = o.lit && o.normalReach > 1.0f;
    M lacks = none();
    if (grades || !smooths) {
        beside.gradient = gradientAt<K>(s.field, s.help, here, o.gradient, p, adds, rows);
        lacks = wanted & ~adds;
        gradients += static_cast<unsigned>(count(adds));
    }
    if (grades) {
        extinction = extinction * gradientFactor(o, beside.gradient);
        if (!hasLabels)
            adds = adds & (extinction > F(0.0f));
    }
    if (smooths && any(adds)) {
        const M shown = adds;
        beside.gradient = otherDifferences<K>(s.field, here, PacketGradient::sobel, p, adds, o.normalReach);
        lacks = lacks | (shown & ~adds);
        gradients += static_cast<unsigned>(count(adds));
    }
    return lacks;
}

/// Takes the labels' shares of extinctions, and their medium's gradient where that prevails. Arguments and
/// result as above.
template <bool Mixed>
TESSERA_LANE M shareByLabels(const PacketScene& s, const Here<Mixed>& here, F3 p, Beside& beside,
                             F& extinction, M& adds) {
    const F function = leaf::labelledFunction(beside.labels, extinction);
    const M inMedium = adds & (beside.medium > function);
    M lacks = none();
    if (s.optics.lit && any(inMedium)) {
        M there = inMedium;
        beside.gradient = select(inMedium, mediumGradient<Mixed>(s, here, p, there), beside.gradient);
        lacks = inMedium & ~there;
        adds = adds & ~lacks;
    }
    const F sum = function + beside.medium;
    beside.ofLabels = leaf::labelledPart(beside.labels, extinction, beside.medium, sum);
    extinction = sum;
    adds = adds & (sum > F(0.0f));
    return lacks;
}

TESSERA_LANE F3 colouredByLabels(const Beside& beside, F3 colour) {
    return {leaf::labelledColour(beside.labels, colour.x, beside.labels.red, beside.ofLabels),
            leaf::labelledColour(beside.labels, colour.y, beside.labels.green, beside.ofLabels),
            leaf::labelledColour(beside.labels, colour.z, beside.labels.blue, beside.ofLabels)};
}

} // namespace tessera::TESSERA_LANES
