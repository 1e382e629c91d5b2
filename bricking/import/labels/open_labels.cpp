// bricking/import/labels/open_labels.cpp: see open_labels.h.
#include "bricking/import/labels/open_labels.h"

#include "bricking/import/labels/label_format.h"
#include "bricking/import/source/source_files.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/files.h"

#include <algorithm>
#include <system_error>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostMasks = 65535; // labels of a table

/// A layer of a mask: all that is not 0 is inside, and gets the mask's value.
class MaskLayer final : public LabelLayer {
  public:
    MaskLayer(std::unique_ptr<LabelLayer> layer, std::uint32_t value, std::string name)
        : layer_(std::move(layer)), value_(value), name_(std::move(name)) {}
    const VolumeInfo& info() const override { return layer_->info(); }
    bool isAlone() const override { return layer_->isAlone(); }
    void readSlices(int count, std::span<std::uint32_t> out) override {
        layer_->readSlices(count, out);
        for (std::uint32_t& value : out) {
            most_ = std::max(most_, value);
            value = value == 0 ? 0 : value_;
        }
    }
    std::vector<std::string> notes() const override {
        std::vector<std::string> notes = layer_->notes();
        for (std::string& note : notes)
            note = name_ + ": " + note;
        if (most_ > 1)
            notes.push_back(name_ + ": has values other than 0 and 1, up to " + std::to_string(most_) +
                            "; all that is not 0 is inside");
        return notes;
    }

  private:
    std::unique_ptr<LabelLayer> layer_;
    std::uint32_t value_;
    std::string name_;
    std::uint32_t most_ = 0;
};

struct Mask {
    fs::path file;
    const LabelFormat* format;
};

LabelFile openMasks(const fs::path& folder, const SourceOptions& options) {
    std::vector<Mask> masks;
    std::size_t others = 0;
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.path().filename().string().starts_with('.') || entry.is_directory())
            continue;
        const LabelFormat* const format = labelFormatOf(entry.path());
        if (format && format->areMasks)
            masks.push_back({entry.path(), format});
        else
            ++others;
    }
    if (masks.empty())
        throw badFile(folder.string(), "masks: " + namedLabelFormats(),
                      std::to_string(others) + " files of other kinds");
    if (masks.size() > kMostMasks)
        throw badFile(folder.string(), "at most " + std::to_string(kMostMasks) + " masks",
                      std::to_string(masks.size()));
    std::sort(masks.begin(), masks.end(),
              [](const Mask& a, const Mask& b) { return a.file.filename() < b.file.filename(); });
    LabelFile all;
    if (others > 0)
        all.notes.push_back(std::to_string(others) +
                            (others == 1 ? " file that is no mask is" : " files that are no masks are") +
                            " left out");
    for (const Mask& mask : masks) {
        LabelFile one = mask.format->open(mask.file, options);
        if (one.layers.size() != 1)
            throw badFile(mask.file.string(), "a mask: one layer", std::to_string(one.layers.size()));
        if (all.layers.empty())
            all.frameOfReference = one.frameOfReference;
        else if (one.frameOfReference != all.frameOfReference)
            throw badFile(mask.file.string(), "the frame of reference of the masks before it",
                          "'" + printable(one.frameOfReference) + "'");
        const auto value = static_cast<std::uint32_t>(all.layers.size() + 1);
        const std::string name = printable(nameWithoutEnding(mask.file, *mask.format));
        all.labels.push_back({value, name.empty() ? "label " + std::to_string(value) : name});
        for (const std::string& note : one.notes)
            all.notes.push_back(name + ": " + note);
        all.layers.push_back(std::make_unique<MaskLayer>(std::move(one.layers.front()), value, name));
    }
    return all;
}

LabelFile openAny(const fs::path& path, const SourceOptions& options) {
    refusePipeOrDevice(path);
    std::error_code none;
    if (!isAddress(path) && !fs::exists(path, none))
        throw badFile(path.string(), "a file or folder of labels", "no such file or folder");
    if (const LabelFormat* format = labelFormatOf(path))
        return format->open(path, options);
    if (fs::is_directory(path, none))
        return openMasks(path, options);
    throw badFile(path.string(), "labels: " + namedLabelFormats(), "another kind of file");
}

} // namespace

LabelFile openLabels(const fs::path& path, const SourceOptions& options) {
    LabelFile file = openAny(path, options);
    file.shown = path.string();
    return file;
}

} // namespace tessera
