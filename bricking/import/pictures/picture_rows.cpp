// bricking/import/pictures/picture_rows.cpp: see picture_rows.h.
#include "bricking/import/pictures/picture_rows.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <string>
#include <utility>

namespace tessera {
namespace {

OIIO::TypeDesc descOf(FileType type) {
    switch (type) {
    case FileType::i8:
        return OIIO::TypeDesc::INT8;
    case FileType::u8:
        return OIIO::TypeDesc::UINT8;
    case FileType::i16:
        return OIIO::TypeDesc::INT16;
    case FileType::u16:
        return OIIO::TypeDesc::UINT16;
    case FileType::i32:
        return OIIO::TypeDesc::INT32;
    case FileType::u32:
        return OIIO::TypeDesc::UINT32;
    case FileType::i64:
        return OIIO::TypeDesc::INT64;
    case FileType::u64:
        return OIIO::TypeDesc::UINT64;
    case FileType::f32:
        return OIIO::TypeDesc::FLOAT;
    case FileType::f64:
        break;
    }
    return OIIO::TypeDesc::DOUBLE;
}

class OpenedPicture final : public PictureRows {
  public:
    OpenedPicture(std::filesystem::path path, const PictureShape& shape)
        : path_(std::move(path)), shape_(shape) {
        OIIO::attribute("threads", 1); // importers have threads of their own
        input_ = OIIO::ImageInput::create(shape.format);
        OIIO::ImageSpec spec;
        if (!input_ || !input_->open(path_.string(), spec))
            refuse("a readable picture (" + std::string(shape.format) + ")", problem());
        check();
    }

    void read(int page, int first, int count, std::span<std::byte> out) override {
        TESSERA_CHECK(out.size() == static_cast<std::size_t>(count) *
                                        static_cast<std::size_t>(shape_.size.x) *
                                        bytesPerFileValue(shape_.type));
        if (page != page_) {
            if (!input_->seek_subimage(page, 0))
                refuse("page " + std::to_string(page + 1), "none that can be read (" + problem() + ")");
            page_ = page;
            check();
        }
        const OIIO::ImageSpec& spec = input_->spec();
        const OIIO::TypeDesc type = descOf(shape_.type);
        const int top = spec.y + first; // of a picture that was cut from another, x and y are not 0
        const bool done = spec.tile_width > 0
                              ? input_->read_tiles(page_, 0, spec.x, spec.x + spec.width, top, top + count, 0,
                                                   1, 0, 1, type, out.data())
                              : input_->read_scanlines(page_, 0, top, top + count, 0, 0, 1, type, out.data());
        // A decoder that goes on behind a fault leaves its words.
        if (!done || input_->has_error())
            refuse(std::to_string(shape_.size.y) + " rows of pixels in page " + std::to_string(page + 1),
                   "an end or a fault in or after row " + std::to_string(first) + " (" + problem() + ")");
    }

  private:
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(path_.string(), expected, found);
    }
    std::string problem() {
        std::string text = input_ ? input_->geterror() : OIIO::geterror();
        std::replace(text.begin(), text.end(), '\n', ' ');
        constexpr std::size_t kMostShown = 200;
        return text.empty() ? "none" : printable(text.substr(0, kMostShown));
    }
    void check() {
        const OIIO::ImageSpec& spec = input_->spec();
        const bool isHalf = spec.format == OIIO::TypeDesc::HALF && shape_.type == FileType::f32;
        const bool isGrey = spec.nchannels == 1 || (shape_.isPalette && spec.nchannels == 3);
        if (spec.width != shape_.size.x || spec.height != shape_.size.y || !isGrey || spec.depth > 1 ||
            spec.deep || (spec.format != descOf(shape_.type) && !isHalf))
            refuse(std::to_string(shape_.size.x) + "x" + std::to_string(shape_.size.y) + " pixels of " +
                       name(shape_.type),
                   std::to_string(spec.width) + "x" + std::to_string(spec.height) + " pixels of " +
                       std::to_string(spec.nchannels) + " x " + spec.format.c_str() + " in page " +
                       std::to_string(page_ + 1));
    }

    std::filesystem::path path_;
    PictureShape shape_;
    std::unique_ptr<OIIO::ImageInput> input_;
    int page_ = 0;
};

} // namespace

std::unique_ptr<PictureRows> openPictureRows(const std::filesystem::path& file, const PictureShape& shape) {
    return std::make_unique<OpenedPicture>(file, shape);
}

} // namespace tessera
