// bricking/import/files/file_format.cpp: see file_format.h.
#include "bricking/import/files/file_format.h"

#include <algorithm>
#include <cctype>

namespace tessera {

const FileFormat* fileFormatOf(const std::filesystem::path& file) {
    std::string name = file.filename().string();
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const FileFormat* best = nullptr;
    std::size_t longest = 0;
    for (const FileFormat& format : fileFormats())
        for (const std::string& ending : format.endings)
            if (name.size() > ending.size() && ending.size() > longest && name.ends_with(ending)) {
                best = &format;
                longest = ending.size();
            }
    return best;
}

std::string withFormats(const std::string& first, std::string FileFormat::*text) {
    std::string all = first;
    for (const FileFormat& format : fileFormats())
        all += ", " + format.*text;
    const std::size_t last = all.rfind(", ");
    return last == std::string::npos ? all : all.replace(last, 2, " or ");
}

} // namespace tessera
