// core/base/fnv_hash.h: FnvHash, FNV-1a of 64 bits: a digest of what is compared, not of what is attacked.
#pragma once

#include <cstdint>
#include <cstdio>
#include <span>
#include <string>

namespace tessera {

class FnvHash {
  public:
    /// @param unit  a byte, or a wider number that is taken as one
    void add(std::uint64_t unit) { hash_ = (hash_ ^ unit) * 0x100000001b3u; }
    void addBytes(std::span<const char> bytes) {
        for (const char byte : bytes)
            add(static_cast<unsigned char>(byte));
    }
    /// 16 hexadecimal digits.
    std::string digits() const {
        char text[17];
        std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash_));
        return text;
    }

  private:
    std::uint64_t hash_ = 0xcbf29ce484222325u;
};

} // namespace tessera
