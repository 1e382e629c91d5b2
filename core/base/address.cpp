// core/base/address.cpp: see address.h.
#include "core/base/address.h"

#include <algorithm>
#include <string_view>

namespace tessera {

bool isAddress(const std::filesystem::path& path) {
    const std::string_view text = path.native();
    return text.starts_with("http://") || text.starts_with("https://") || text.starts_with("s3://");
}

std::string withoutSecrets(const std::string& address) {
    std::string text = address.substr(0, address.find_first_of("?#"));
    const std::size_t host = text.find("://");
    if (host == std::string::npos)
        return text;
    const std::size_t begin = host + 3, end = std::min(text.find('/', begin), text.size());
    if (const std::size_t at = text.rfind('@', end); at != std::string::npos && at >= begin)
        text.erase(begin, at + 1 - begin);
    return text;
}

std::filesystem::path keptPlace(const std::filesystem::path& path) {
    return isAddress(path) ? std::filesystem::path(withoutSecrets(path.string())) : absolutePlace({}, path);
}

std::filesystem::path absolutePlace(const std::filesystem::path& folder, const std::filesystem::path& path) {
    if (isAddress(path))
        return path;
    return std::filesystem::absolute(folder / path).lexically_normal();
}

} // namespace tessera
