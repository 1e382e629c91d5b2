// core/base/address.cpp: see address.h.
#include "core/base/address.h"

#include <algorithm>
#include <string_view>

namespace tessera {

namespace {

std::string lower(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(),
                   [](unsigned char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c); });
    return out;
}

/// True for "host" and "host:80", not for "user:word" of an address whose '/' or '?' in it was not escaped.
bool isHost(std::string_view text) {
    const std::size_t colon = text.rfind(':');
    return colon == std::string_view::npos || text.front() == '[' ||
           text.find_first_not_of("0123456789", colon + 1) == std::string_view::npos;
}

} // namespace

bool isAddress(const std::filesystem::path& path) {
    const std::string begin = lower(path.native().substr(0, std::string_view("https://").size()));
    return begin.starts_with("http://") || begin.starts_with("https://") || begin.starts_with("s3://");
}

std::string withPlainScheme(const std::string& address) {
    const std::size_t end = std::min(address.find("://"), address.size());
    return lower(address.substr(0, end)) + address.substr(end);
}

std::string withoutSecrets(const std::string& address) {
    const std::size_t scheme = address.find("://");
    if (scheme == std::string::npos)
        return address.substr(0, address.find_first_of("?#"));
    const std::string begin = lower(address.substr(0, scheme + 3));
    std::string rest = address.substr(scheme + 3);
    const std::size_t stop = rest.find_first_of("/?#@"), last = rest.rfind('@');
    if (last != std::string::npos && rest[stop] != '@' && !isHost(std::string_view(rest).substr(0, stop)))
        rest.erase(0, last + 1);
    rest.resize(std::min(rest.find_first_of("?#"), rest.size()));
    const std::size_t end = std::min(rest.find('/'), rest.size());
    if (const std::size_t at = rest.rfind('@', end); at != std::string::npos)
        rest.erase(0, at + 1);
    return begin + rest;
}

std::filesystem::path keptPlace(const std::filesystem::path& path) {
    return isAddress(path) ? std::filesystem::path(withoutSecrets(path.string())) : absolutePlace({}, path);
}

std::string shownName(const std::filesystem::path& path) {
    return isAddress(path) ? std::filesystem::path(withoutSecrets(path.string())).filename().string()
                           : path.filename().string();
}

std::filesystem::path absolutePlace(const std::filesystem::path& folder, const std::filesystem::path& path) {
    if (isAddress(path))
        return path;
    return std::filesystem::absolute(folder / path).lexically_normal();
}

} // namespace tessera
