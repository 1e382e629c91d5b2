// bricking/import/files/vdb/vdb_values.cpp: see vdb_values.h. Rules: io/Compression.h of OpenVDB 10.
#include "bricking/import/files/vdb/vdb_values.h"

#include "bricking/import/source/half_floats.h"

#include <algorithm>
#include <bit>
#include <blosc.h>
#include <cstring>
#include <zlib.h>

namespace tessera {
namespace {

// What follows of inactive values.
enum Kept : std::uint8_t {
    kBackground,      // they are it
    kMinus,           // they are its negative
    kOne,             // they have one other value
    kBackgroundOr,    // it or its negative, by a mask
    kOneOrBackground, // one other value or it
    kTwo,             // two other values
    kAll              // all values are there
};

std::size_t countOn(VdbMask mask) {
    std::size_t count = 0;
    for (const std::byte byte : mask)
        count += static_cast<std::size_t>(std::popcount(std::to_integer<unsigned>(byte)));
    return count;
}

} // namespace

VdbValues::Inactive VdbValues::beginningOf(VdbBytes& bytes, VdbMask active) const {
    Inactive inactive;
    const auto kept = bytes.number<std::uint8_t>();
    if (kept > kAll)
        bytes.refuse("inactive values of a known kind", std::to_string(kept));
    inactive.values[0] = kept == kBackground ? background_ : -background_;
    inactive.values[1] = background_;
    if (kept == kOne || kept == kOneOrBackground || kept == kTwo)
        inactive.values[0] = bytes.number<float>();
    if (kept == kTwo)
        inactive.values[1] = bytes.number<float>();
    if (kept == kBackgroundOr || kept == kOneOrBackground || kept == kTwo) {
        inactive.selection.resize(active.size());
        bytes.read(inactive.selection);
    }
    inactive.stored =
        (compression_ & kVdbActiveMask) != 0 && kept != kAll ? countOn(active) : 8 * active.size();
    return inactive;
}

std::size_t VdbValues::bytesOf(std::size_t count) const {
    return count * (isHalf_ ? sizeof(std::uint16_t) : sizeof(float));
}

std::uint64_t VdbValues::packedLength(VdbBytes& bytes, std::size_t plain) const {
    if ((compression_ & (kVdbZip | kVdbBlosc)) == 0 || (isHalf_ && plain == 0))
        return 0;
    const auto said = bytes.number<std::int64_t>();
    constexpr std::uint64_t kMostMore = 64; // than the plain ones
    const std::uint64_t length =
        said < 0 ? ~static_cast<std::uint64_t>(said) + 1 : static_cast<std::uint64_t>(said);
    if (said <= 0 ? length != plain : length > plain + kMostMore)
        bytes.refuse(std::to_string(plain) + " bytes of values", "a length of " + std::to_string(said));
    return said <= 0 ? 0 : length;
}

void VdbValues::readNumbers(VdbBytes& bytes, std::span<float> out) {
    plain_.resize(bytesOf(out.size()));
    if (const std::uint64_t length = packedLength(bytes, plain_.size()); length > 0) {
        packed_.resize(length);
        bytes.read(packed_);
        if ((compression_ & kVdbBlosc) != 0) {
            std::size_t said = 0;
            if (blosc_cbuffer_validate(packed_.data(), packed_.size(), &said) != 0 || said != plain_.size() ||
                blosc_decompress_ctx(packed_.data(), plain_.data(), plain_.size(), 1) !=
                    static_cast<int>(plain_.size()))
                bytes.refuse("values packed by Blosc", "damage before byte " + std::to_string(bytes.at()));
        } else {
            uLongf got = plain_.size();
            if (uncompress(reinterpret_cast<Bytef*>(plain_.data()), &got,
                           reinterpret_cast<const Bytef*>(packed_.data()), packed_.size()) != Z_OK ||
                got != plain_.size())
                bytes.refuse("values packed by zlib", "damage before byte " + std::to_string(bytes.at()));
        }
    } else {
        bytes.read(plain_);
    }
    if (!isHalf_) {
        if (!out.empty())
            std::memcpy(out.data(), plain_.data(), plain_.size());
        return;
    }
    for (std::size_t n = 0; n < out.size(); ++n) {
        std::uint16_t half = 0;
        std::memcpy(&half, plain_.data() + n * sizeof half, sizeof half);
        out[n] = floatOfHalf(half);
    }
}

void VdbValues::read(VdbBytes& bytes, VdbMask active, std::span<float> out) {
    const Inactive inactive = beginningOf(bytes, active);
    if (inactive.stored == out.size()) {
        readNumbers(bytes, out);
        return;
    }
    numbers_.resize(inactive.stored);
    readNumbers(bytes, numbers_);
    std::size_t next = 0;
    for (std::size_t n = 0; n < out.size(); ++n)
        out[n] = isOn(active, n)
                     ? numbers_[next++]
                     : inactive.values[!inactive.selection.empty() && isOn(inactive.selection, n)];
}

void VdbValues::skip(VdbBytes& bytes, VdbMask active) {
    const std::size_t plain = bytesOf(beginningOf(bytes, active).stored);
    const std::uint64_t length = packedLength(bytes, plain);
    bytes.skip(length > 0 ? length : plain);
}

} // namespace tessera
