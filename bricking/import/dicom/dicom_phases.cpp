// bricking/import/dicom/dicom_phases.cpp: see dicom_phases.h.
#include "bricking/import/dicom/dicom_phases.h"

#include "bricking/import/dicom/dicom_geometry.h" // kSamePlaceMm
#include "bricking/import/source/source_files.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <set>

namespace tessera {
namespace {

constexpr std::size_t kPartBytes = std::size_t{1} << 20; // compared at once

/// Slices by position; those without one are left out.
std::vector<std::vector<std::size_t>> placesOf(const DicomSeries& series) {
    std::vector<std::size_t> order;
    glm::dvec3 normal(0, 0, 1);
    for (std::size_t i = 0; i < series.slices.size(); ++i) {
        const DicomSlice& slice = series.slices[i];
        if (!slice.positionMm)
            continue;
        if (order.empty() && slice.rowDirection)
            normal = glm::cross(*slice.rowDirection, *slice.columnDirection);
        order.push_back(i);
    }
    const auto at = [&](std::size_t i) { return *series.slices[i].positionMm; };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return glm::dot(at(a), normal) < glm::dot(at(b), normal);
    });
    std::vector<std::vector<std::size_t>> places;
    for (const std::size_t i : order) {
        if (places.empty() || !(glm::length(at(i) - at(places.back().front())) < kSamePlaceMm))
            places.emplace_back();
        places.back().push_back(i);
    }
    return places;
}

bool sameBytes(const DicomSlice& a, std::uint64_t fromA, const DicomSlice& b, std::uint64_t fromB,
               std::uint64_t count) {
    const InputFile fileA(a.file), fileB(b.file);
    std::vector<std::byte> partA, partB;
    for (std::uint64_t done = 0; done < count; done += partA.size()) {
        partA.resize(std::min<std::uint64_t>(kPartBytes, count - done));
        partB.resize(partA.size());
        fileA.readAt(fromA + done, partA);
        fileB.readAt(fromB + done, partB);
        if (partA != partB)
            return false;
    }
    return true;
}

bool samePixels(const DicomSlice& a, const DicomSlice& b) {
    try {
        if (a.coding == PixelCoding::littleEndian || a.coding == PixelCoding::bigEndian)
            return sameBytes(a, a.pixelOffsetBytes, b, b.pixelOffsetBytes,
                             static_cast<std::uint64_t>(a.columns) * static_cast<std::uint64_t>(a.rows) *
                                 static_cast<std::uint64_t>(a.bitsAllocated / 8));
        const std::uint64_t sizeA = InputFile(a.file).sizeBytes(), sizeB = InputFile(b.file).sizeBytes();
        const bool whole = a.coding == PixelCoding::deflated; // its offset is not one of the file
        const std::uint64_t fromA = whole ? 0 : a.pixelOffsetBytes, fromB = whole ? 0 : b.pixelOffsetBytes;
        return sizeA > fromA && sizeB > fromB && sizeA - fromA == sizeB - fromB &&
               sameBytes(a, fromA, b, fromB, sizeA - fromA);
    } catch (const Error&) {
        return false; // reading the slice itself reports it
    }
}

/// Everything in the header about the image, except its file.
bool sameHeader(const DicomSlice& a, const DicomSlice& b) {
    return a.coding == b.coding && a.columns == b.columns && a.rows == b.rows &&
           a.bitsAllocated == b.bitsAllocated && a.bitsStored == b.bitsStored && a.highBit == b.highBit &&
           a.isSigned == b.isSigned && a.slope == b.slope && a.intercept == b.intercept &&
           a.paddingFirst == b.paddingFirst && a.paddingLast == b.paddingLast &&
           a.rowDirection == b.rowDirection && a.columnDirection == b.columnDirection &&
           a.spacingMm == b.spacingMm && a.moment == b.moment;
}

struct Key {
    const char* before;
    const char* after;
    std::optional<double> (*of)(const SliceMoment&);
};
std::optional<double> real(const std::optional<int>& number) {
    return number ? std::optional<double>(*number) : std::nullopt;
}
/// Header values that number phases, most reliable first.
const Key kKeys[] = {
    {"phase ", " %", [](const SliceMoment& m) { return m.cardiacPercent; }},
    {"time ", "", [](const SliceMoment& m) { return real(m.temporalPosition); }},
    {"trigger time ", " ms", [](const SliceMoment& m) { return m.triggerMs; }},
    {"acquisition ", "", [](const SliceMoment& m) { return real(m.acquisition); }},
    {"echo ", "", [](const SliceMoment& m) { return real(m.echo); }},
};
/// Header values that only give an order at each position.
const Key kOrders[] = {
    {"time ", "", [](const SliceMoment& m) { return m.triggerMs; }},
    {"time ", "", [](const SliceMoment& m) { return m.acquisitionSecond; }},
    {"time ", "", [](const SliceMoment& m) { return m.contentSecond; }},
};

std::string numbered(const Key& key, double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return key.before + std::string(text) + key.after;
}

/// By the value of the key, if there are as many values as images at the fullest position, and they
/// distinguish all images.
std::vector<DicomPhase> byValue(const DicomSeries& series,
                                const std::vector<std::vector<std::size_t>>& places, std::size_t most,
                                const Key& key) {
    std::map<double, DicomPhase> phases;
    for (const auto& place : places) {
        std::set<double> here;
        for (const std::size_t i : place) {
            const auto value = key.of(series.slices[i].moment);
            if (!value || !here.insert(*value).second)
                return {};
            phases[*value].slices.push_back(i);
        }
    }
    if (phases.size() != most)
        return {};
    std::vector<DicomPhase> list;
    for (auto& [value, phase] : phases)
        list.push_back({numbered(key, value), std::move(phase.slices)});
    return list;
}

/// By the order of the key's values at each position, if every position has equally many images.
std::vector<DicomPhase> byOrder(const DicomSeries& series,
                                const std::vector<std::vector<std::size_t>>& places, std::size_t most,
                                const Key& key) {
    std::vector<DicomPhase> phases(most);
    for (const auto& place : places) {
        std::map<double, std::size_t> here;
        for (const std::size_t i : place) {
            const auto value = key.of(series.slices[i].moment);
            if (!value || !here.emplace(*value, i).second)
                return {};
        }
        if (here.size() != most)
            return {};
        std::size_t rank = 0;
        for (const auto& [value, i] : here)
            phases[rank++].slices.push_back(i);
    }
    for (std::size_t rank = 0; rank < most; ++rank)
        phases[rank].label = numbered(key, static_cast<double>(rank + 1));
    return phases;
}

} // namespace

std::size_t dropDuplicates(DicomSeries& series) {
    std::set<std::size_t> gone;
    for (const auto& place : placesOf(series))
        for (std::size_t n = 1; n < place.size(); ++n)
            for (std::size_t before = 0; before < n; ++before) {
                const DicomSlice &a = series.slices[place[before]], &b = series.slices[place[n]];
                if (gone.contains(place[before]) || !sameHeader(a, b) || !samePixels(a, b))
                    continue;
                gone.insert(place[n]);
                break;
            }
    if (gone.empty())
        return 0;
    std::vector<DicomSlice> kept;
    for (std::size_t i = 0; i < series.slices.size(); ++i)
        if (!gone.contains(i))
            kept.push_back(std::move(series.slices[i]));
    series.slices = std::move(kept);
    return gone.size();
}

std::vector<DicomPhase> phasesOf(const DicomSeries& series) {
    const auto places = placesOf(series);
    std::size_t most = 0;
    for (const auto& place : places)
        most = std::max(most, place.size());
    if (most < 2)
        return {};
    for (const Key& key : kKeys)
        if (auto phases = byValue(series, places, most, key); !phases.empty())
            return phases;
    for (const Key& key : kOrders)
        if (auto phases = byOrder(series, places, most, key); !phases.empty())
            return phases;
    return {};
}

} // namespace tessera
