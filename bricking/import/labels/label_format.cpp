// bricking/import/labels/label_format.cpp: see label_format.h.
#include "bricking/import/labels/label_format.h"

#include <algorithm>
#include <cctype>
#include <system_error>

namespace tessera {
namespace fs = std::filesystem;

namespace {
/// Bytes of the longest ending of a format that a name has; 0: none.
std::size_t endingOf(const fs::path& file, const LabelFormat& format) {
    std::string name = file.filename().string();
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    std::size_t longest = 0;
    for (const std::string& ending : format.endings)
        if (name.size() > ending.size() && ending.size() > longest && name.ends_with(ending))
            longest = ending.size();
    return longest;
}
} // namespace

const LabelFormat* labelFormatOf(const fs::path& path) {
    const LabelFormat* best = nullptr;
    std::size_t longest = 0;
    std::error_code ignored;
    if (!fs::is_directory(path, ignored))
        for (const LabelFormat& format : labelFormats())
            if (const std::size_t ending = endingOf(path, format); ending > longest) {
                best = &format;
                longest = ending;
            }
    if (best)
        return best;
    for (const LabelFormat& format : labelFormats())
        if (format.isMeant && format.isMeant(path))
            return &format;
    return nullptr;
}

std::string nameWithoutEnding(const fs::path& file, const LabelFormat& format) {
    const std::string name = file.filename().string();
    return name.substr(0, name.size() - endingOf(file, format));
}

std::string namedLabelFormats() {
    std::string all;
    for (const LabelFormat& format : labelFormats())
        all += (all.empty() ? "" : ", ") + format.named;
    const std::size_t last = all.rfind(", ");
    return last == std::string::npos ? all : all.replace(last, 2, " or ");
}

} // namespace tessera
