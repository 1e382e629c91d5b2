// core/image/environment_file.cpp: see environment_file.h.
#include "core/image/environment_file.h"

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/shown_text.h"

#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <glm/common.hpp>
#include <memory>
#include <string_view>

namespace tessera {
namespace {

constexpr int kRowsAtATime = 32, kRowsOfDwab = 256; // as many as OpenEXR packs together: at most, and then
constexpr int kMostTileRows = 256, kMostChannels = 16;
constexpr double kTurn = 3.14159265358979323846; // half a turn, from the first row to the last

using Row = std::vector<glm::dvec3>;

/// Its format by its first bytes; "": another one.
std::string formatOf(const std::filesystem::path& path) {
    std::array<char, 4> bytes{};
    std::ifstream file(path, std::ios::binary);
    file.read(bytes.data(), bytes.size());
    const std::string_view begin(bytes.data(),
                                 static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
    return begin == "\x76\x2f\x31\x01" ? "openexr" : begin.starts_with("#?") ? "hdr" : "";
}

/// A picture being read, by OpenImageIO.
class Picture {
  public:
    explicit Picture(const std::filesystem::path& path) : path_(path) {
        std::error_code ignored;
        if (std::filesystem::is_directory(path, ignored))
            refuse("a file", "a folder");
        if (!std::filesystem::exists(path, ignored))
            refuse("a file", "nothing there");
        refusePipeOrDevice(path);
        const std::string format = formatOf(path);
        if (format.empty())
            refuse("a picture in OpenEXR's or Radiance's format", "another file");
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", -1); // none of its own
        input_ = OIIO::ImageInput::create(format);
        if (!input_ || !input_->open(path.string(), spec_))
            refuse("a readable picture", problem());
        check();
    }

    glm::ivec2 size() const { return {spec_.width, spec_.height}; }
    /// Rows that are read together.
    int band() const { return spec_.tile_width > 0 ? spec_.tile_height : kRowsAtATime; }
    /// Three numbers a pixel, or one.
    int channels() const { return isGrey_ ? 1 : 3; }
    std::size_t bandBytes() const {
        // What is unpacked, of all channels, and what comes out.
        const bool isDwab = std::string(spec_.get_string_attribute("compression")).starts_with("dwab");
        return static_cast<std::size_t>(std::max(spec_.width, spec_.tile_width)) *
               static_cast<std::size_t>(std::max(band(), isDwab ? kRowsOfDwab : 0)) * sizeof(float) *
               static_cast<std::size_t>(2 * spec_.nchannels + channels());
    }
    void read(int row, int count, float* values) {
        const int y = spec_.y + row;
        const bool done =
            spec_.tile_width > 0
                ? input_->read_tiles(0, 0, spec_.x, spec_.x + spec_.width, y, y + count, 0, 1, 0, channels(),
                                     OIIO::TypeDesc::FLOAT, values)
                : input_->read_scanlines(0, 0, y, y + count, 0, 0, channels(), OIIO::TypeDesc::FLOAT, values);
        if (!done)
            refuse(std::to_string(spec_.height) + " rows of pixels",
                   "an end or a fault in or after row " + std::to_string(row) + " (" + problem() + ")");
    }
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(path_.string(), expected, found);
    }

  private:
    std::string problem() {
        std::string text = input_ ? input_->geterror() : OIIO::geterror();
        std::replace(text.begin(), text.end(), '\n', ' ');
        return text.empty() ? "none" : printable(text.substr(0, 200));
    }
    void check() {
        isGrey_ = spec_.nchannels == 1 && spec_.channelnames[0] == "Y";
        const auto sizeText = std::to_string(spec_.width) + "x" + std::to_string(spec_.height);
        if (spec_.width != 2 * static_cast<std::int64_t>(spec_.height) || spec_.height < 1 ||
            spec_.width > EnvironmentPixels::kMostColumns)
            refuse("a picture of all directions, twice as wide as high, 2x1 to 4096x2048 pixels", sizeText);
        if (spec_.depth > 1 || spec_.deep)
            refuse("a flat picture", "a deep one");
        if (spec_.full_width != spec_.width || spec_.full_height != spec_.height || spec_.full_x != spec_.x ||
            spec_.full_y != spec_.y)
            refuse("pixels for the whole picture", "a part of it");
        if (spec_.get_int_attribute("Orientation", 1) != 1)
            refuse("rows from the top, columns from the left", "another order");
        if (spec_.nchannels < 1 || spec_.nchannels > kMostChannels)
            refuse("at most " + std::to_string(kMostChannels) + " channels", std::to_string(spec_.nchannels));
        const std::vector<std::string>& names = spec_.channelnames;
        if (!isGrey_ && (names.size() < 3 || names[0] != "R" || names[1] != "G" || names[2] != "B"))
            refuse("channels R, G and B, or Y", "\"" + printable(names.empty() ? "" : names[0]) + "\"");
        if (spec_.tile_width > EnvironmentPixels::kMostColumns || spec_.tile_height > kMostTileRows)
            refuse("tiles of at most " + std::to_string(EnvironmentPixels::kMostColumns) + "x" +
                       std::to_string(kMostTileRows) + " pixels",
                   std::to_string(spec_.tile_width) + "x" + std::to_string(spec_.tile_height));
    }

    const std::filesystem::path path_;
    std::unique_ptr<OIIO::ImageInput> input_;
    OIIO::ImageSpec spec_;
    bool isGrey_ = false;
};

/// The parts that a number of equal parts of [0,1] has of another number of them: f(part, from, to).
template <typename Each> void overlaps(int number, int of, int among, Each&& each) {
    const std::int64_t first = std::int64_t{number} * among / of,
                       last = ((std::int64_t{number} + 1) * among - 1) / of;
    for (std::int64_t part = first; part <= last; ++part)
        each(static_cast<int>(part),
             std::max(static_cast<double>(number) / of, static_cast<double>(part) / among),
             std::min((number + 1.0) / of, (static_cast<double>(part) + 1) / among));
}
double heightOf(double share) {
    return std::cos(kTurn * share);
}

/// Sums over the sphere of the pixels within each texel.
class Reduction {
  public:
    Reduction(const glm::ivec2& from, const glm::ivec2& to)
        : from_(from), to_(to), row_(static_cast<std::size_t>(to.x)),
          sums_(static_cast<std::size_t>(to.x) * static_cast<std::size_t>(to.y)) {}

    static std::size_t bytes(const glm::ivec2& to) {
        return sizeof(glm::dvec3) * static_cast<std::size_t>(to.x) * (1 + static_cast<std::size_t>(to.y));
    }
    void add(int number, const Row& pixels) {
        std::fill(row_.begin(), row_.end(), glm::dvec3(0));
        for (int column = 0; column < from_.x; ++column)
            overlaps(column, from_.x, to_.x, [&](int texel, double low, double high) {
                row_[static_cast<std::size_t>(texel)] +=
                    (high - low) * to_.x * pixels[static_cast<std::size_t>(column)];
            });
        overlaps(number, from_.y, to_.y, [&](int row, double low, double high) {
            const double share = (heightOf(low) - heightOf(high)) /
                                 (heightOf(static_cast<double>(row) / to_.y) - heightOf((row + 1.0) / to_.y));
            glm::dvec3* sums = &sums_[static_cast<std::size_t>(row) * static_cast<std::size_t>(to_.x)];
            for (const glm::dvec3& texel : row_)
                *sums++ += share * texel;
        });
    }
    const std::vector<glm::dvec3>& means() const { return sums_; }

  private:
    glm::ivec2 from_, to_;
    Row row_;
    std::vector<glm::dvec3> sums_;
};

} // namespace

EnvironmentPixels readEnvironment(const std::filesystem::path& path, MemoryBudget& ram) {
    Picture picture(path);
    const glm::ivec2 from = picture.size();
    EnvironmentPixels out;
    out.size = glm::min(from, EnvironmentPixels::kKept);
    const auto columns = static_cast<std::size_t>(from.x),
               channels = static_cast<std::size_t>(picture.channels());
    const Charge charge =
        ram.charge(picture.bandBytes() + Reduction::bytes(out.size) + columns * sizeof(glm::dvec3),
                   "reading an environment's file");
    Reduction reduction(from, out.size);
    std::vector<float> values(columns * static_cast<std::size_t>(picture.band()) * channels);
    Row row(columns);
    std::size_t below = 0;
    for (int y = 0; y < from.y; y += picture.band()) {
        const int rows = std::min(picture.band(), from.y - y);
        picture.read(y, rows, values.data());
        const float* value = values.data();
        for (int n = 0; n < rows; ++n) {
            for (std::size_t x = 0; x < columns; ++x)
                for (int c = 0; c < 3; ++c) {
                    const float v = value[x * channels + (channels == 3 ? static_cast<std::size_t>(c) : 0)];
                    if (!(v <= EnvironmentPixels::kMostRadiance) || std::isinf(v))
                        picture.refuse("radiance of at most 1e9", (std::isnan(v) ? std::string("not a number")
                                                                   : std::isinf(v) ? "infinity"
                                                                                   : std::to_string(v)) +
                                                                      " in column " + std::to_string(x) +
                                                                      ", row " + std::to_string(y + n));
                    below += v < 0 ? 1 : 0;
                    row[x][c] = static_cast<double>(std::max(v, 0.0f));
                }
            reduction.add(y + n, row);
            value += columns * channels;
        }
    }
    for (const glm::dvec3& mean : reduction.means())
        out.radiance.emplace_back(mean);
    if (below > 0)
        out.notes.push_back(printable(path.string()) + ": " + std::to_string(below) + " of " +
                            std::to_string(3 * columns * static_cast<std::size_t>(from.y)) +
                            " values are below 0, and count as 0");
    return out;
}

} // namespace tessera
