// viewer/window/folder_listing.cpp: see folder_listing.h.
#include "viewer/window/folder_listing.h"

#include "bricking/import/source/format_endings.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cctype>
#include <system_error>

namespace tessera {
namespace {

namespace fs = std::filesystem;

const std::string kSceneEnding = ".json";

bool endsWithoutCase(const std::string& name, const std::string& ending) {
    return name.size() > ending.size() &&
           std::equal(ending.rbegin(), ending.rend(), name.rbegin(), [](char a, char b) {
               return std::tolower(static_cast<unsigned char>(a)) ==
                      std::tolower(static_cast<unsigned char>(b));
           });
}

bool isDigit(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// "scan 9" before "scan 10".
bool comesBefore(const std::string& a, const std::string& b) {
    std::size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (isDigit(a[i]) && isDigit(b[j])) {
            const auto number = [](const std::string& text, std::size_t& at) {
                while (at < text.size() && text[at] == '0')
                    ++at;
                const std::size_t from = at;
                while (at < text.size() && isDigit(text[at]))
                    ++at;
                return text.substr(from, at - from);
            };
            const std::string m = number(a, i), n = number(b, j);
            if (m.size() != n.size())
                return m.size() < n.size();
            if (m != n)
                return m < n;
            continue;
        }
        const int x = std::tolower(static_cast<unsigned char>(a[i])),
                  y = std::tolower(static_cast<unsigned char>(b[j]));
        if (x != y)
            return x < y;
        ++i, ++j;
    }
    return a.size() - i < b.size() - j;
}

} // namespace

FolderListing listFolder(const fs::path& folder) {
    FolderListing listing;
    std::error_code error;
    listing.folder = fs::absolute(folder, error).lexically_normal();
    fs::directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
        std::error_code ignored;
        const std::string name = entry->path().filename().string();
        if (name.empty() || name.front() == '.')
            continue;
        FolderEntry found;
        found.path = entry->path();
        found.name = printable(name);
        if (entry->is_directory(ignored))
            found.kind =
                endsWithoutCase(name, ".zarr") ? FolderEntry::Kind::store : FolderEntry::Kind::folder;
        else if (const auto& endings = volumeFileEndings();
                 endsWithoutCase(name, kSceneEnding) ||
                 std::any_of(endings.begin(), endings.end(),
                             [&](const std::string& ending) { return endsWithoutCase(name, ending); }))
            found.kind = FolderEntry::Kind::file;
        else {
            ++listing.otherFiles;
            continue;
        }
        listing.entries.push_back(std::move(found));
    }
    if (error)
        listing.problem = "cannot read this folder: " + error.message();
    std::sort(listing.entries.begin(), listing.entries.end(), [](const FolderEntry& a, const FolderEntry& b) {
        return a.kind != b.kind ? a.kind < b.kind : comesBefore(a.name, b.name);
    });
    return listing;
}

fs::path folderAt(const fs::path& path) {
    std::error_code ignored;
    fs::path at = fs::absolute(path, ignored).lexically_normal();
    while (at.has_relative_path() &&
           !(fs::is_directory(at, ignored) && !endsWithoutCase(at.string(), ".zarr")))
        at = at.parent_path();
    return at;
}

} // namespace tessera
