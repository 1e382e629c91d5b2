// render/pixels/kept_samples.h: the sums of a picture's samples in a file, from which a later run goes on to
// the same picture as if it had taken all samples itself (docs/sampling.md, "Pixels").
#pragma once

#include "render/pixels/area_picture.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace tessera {

// The file: a line of text that names the kind; the length of the header, 8 bytes, little-endian; the header,
// a line for each entry, name and value with a tabulator between them; of each picture (colour, then others)
// and each pixel the sums of both sets, four floats each, and, where pixels have more than 1024 samples, what
// rounding took from these; a checksum of all that, 8 bytes.

class KeptSamples {
  public:
    /// What a picture's samples depend on, by name: a value each, in words without tabulators and ends of
    /// lines.
    using Parts = std::map<std::string, std::string>;

    /// Of what samples are, by the program: to be raised where the same scene gives other bits.
    static constexpr int kArithmetic = 3;

    /// Checks the file, if there is one. Throws InputError naming it where it is damaged, no such file, or of
    /// other parts.
    KeptSamples(std::filesystem::path path, Parts parts);

    /// Continues a picture before its first rays. Nothing where there is no file. Returns the samples of a
    /// pixel that were taken over; 0: none. Throws InputError naming the file as above, and where it has more
    /// samples than the picture.
    /// @param most    samples of a pixel
    /// @param ofPlan  what follows from the plan
    int restore(AreaPicture& picture, int most, Parts ofPlan);
    /// Writes the file, if all pixels have equally many samples, more than it holds; the earlier file stays
    /// until it is complete. Throws Error naming it.
    void keep(const AreaPicture& picture);

  private:
    struct Header {
        glm::ivec2 size{0};
        int samples = 0;
        std::size_t pictures = 0;
        Parts parts;
        std::uint64_t sumsAt = 0;
    };
    Header read() const;
    void requireParts(const Header& header) const;
    bool exists() const;

    std::filesystem::path path_;
    Parts parts_;
    int samples_ = 0; // in the file
};

/// A number that stands for a text or for data, in words: 16 hexadecimal digits.
std::string fingerprint(std::span<const std::byte> data);

} // namespace tessera
