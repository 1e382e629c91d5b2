// bricking/import/dicom/folder_walk.cpp: see folder_walk.h.
#include "bricking/import/dicom/folder_walk.h"

#include "bricking/import/dicom/dicom_bare.h"
#include "bricking/import/source/input_file.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <string>

namespace tessera {
namespace {

namespace fs = std::filesystem;

// Names in small letters.
constexpr std::array kNames = {".ds_store",   "thumbs.db",  "desktop.ini", "dicomdir", "autorun.inf",
                               "ehthumbs.db", ".localized", "folder.jpg",  "md5sums",  "sha256sums"};
constexpr std::array kBeginnings = {"._", "readme", "license", "licence", "copying", "changelog"};
constexpr std::array kEndings = {
    ".txt",    ".md",     ".xml",  ".json", ".csv",  ".tsv", ".pdf", ".jpg",  ".jpeg", ".png",
    ".gif",    ".bmp",    ".svg",  ".html", ".htm",  ".css", ".js",  ".md5",  ".sha",  ".sha1",
    ".sha256", ".sha512", ".log",  ".url",  ".lnk",  ".exe", ".dll", ".inf",  ".ini",  ".doc",
    ".docx",   ".xls",    ".xlsx", ".rtf",  ".yaml", ".yml", ".py",  ".sh",   ".bat",  ".sqlite",
    ".db",     ".m",      ".webp", ".mp4",  ".jar",  ".ico", ".ttf", ".woff", ".bval", ".bvec"};
constexpr std::array kFoldersNotEntered = {"__macosx",        "$recycle.bin", "system volume information",
                                           "lost+found",      ".trashes",     ".trash",
                                           ".spotlight-v100", ".fseventsd",   ".git"};

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

void walk(const fs::path& folder, FolderFiles& found) {
    const auto unreadable = [&](const std::error_code& error) {
        found.passed.push_back({folder, PassedReason::folderNotReadable, "", error.message()});
    };
    std::error_code error;
    fs::directory_iterator it(folder, error);
    if (error)
        return unreadable(error);
    if (it == fs::directory_iterator())
        found.passed.push_back({folder, PassedReason::emptyFolder});
    for (; it != fs::directory_iterator(); it.increment(error)) { // an error makes it the end
        const fs::path& path = it->path();
        std::error_code none;
        const bool isLink = it->is_symlink(none);
        const fs::file_status status = it->status(none); // of what a link leads to
        if (fs::is_directory(status)) {
            const std::string name = lower(path.filename().string());
            if (isLink)
                found.passed.push_back({path, PassedReason::folderLink});
            else if (lower(path.extension().string()) == ".zarr")
                found.passed.push_back({path, PassedReason::zarr});
            else if (std::find(kFoldersNotEntered.begin(), kFoldersNotEntered.end(), name) ==
                     kFoldersNotEntered.end())
                walk(path, found);
        } else if (fs::is_regular_file(status)) {
            found.files.push_back(path);
        } else if (!isNeverASlice(path)) {
            const bool isThere = status.type() != fs::file_type::not_found &&
                                 status.type() != fs::file_type::none &&
                                 status.type() != fs::file_type::unknown;
            found.passed.push_back({path, PassedReason::notReadable, "",
                                    isThere  ? "a pipe, a socket or a device"
                                    : isLink ? "a link to nothing"
                                             : "no permission to look at it"});
        }
    }
    if (error)
        unreadable(error);
}

} // namespace

FolderFiles walkFolder(const fs::path& folder) {
    FolderFiles found;
    walk(folder, found);
    std::sort(found.files.begin(), found.files.end());
    std::stable_sort(found.passed.begin(), found.passed.end(),
                     [](const PassedFile& a, const PassedFile& b) { return a.path < b.path; });
    return found;
}

bool isNeverASlice(const fs::path& path) {
    const std::string name = lower(path.filename().string());
    if (std::find(kNames.begin(), kNames.end(), name) != kNames.end())
        return true;
    if (std::any_of(kBeginnings.begin(), kBeginnings.end(),
                    [&](const char* begin) { return name.rfind(begin, 0) == 0; }))
        return true;
    const std::string ending = lower(path.extension().string());
    return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

bool isNeverOpened(const fs::path& path) {
    const std::string name = lower(path.filename().string());
    return name.rfind("._", 0) == 0 || std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

bool hasSlicesMark(const fs::path& path) {
    try {
        std::array<std::byte, 132> head{};
        return InputFile(path).readSome(0, head) == head.size() &&
               std::memcmp(head.data() + 128, "DICM", 4) == 0;
    } catch (const Error&) {
        return false;
    }
}

Beginning beginningOf(const fs::path& path) {
    try {
        const InputFile file(path);
        if (file.sizeBytes() == 0)
            return {FileStart::empty, ""};
        constexpr std::size_t kLookedAt = 4096; // the zeros of a preamble are 128
        std::array<std::byte, kLookedAt> head{};
        const std::size_t got = file.readSome(0, head);
        const auto bytes = std::span(head).first(got);
        if (got >= 132 && std::memcmp(head.data() + 128, "DICM", 4) == 0)
            return {FileStart::dicom, ""};
        if (std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; }))
            return {FileStart::zeros, ""};
        return {looksLikeBareDicom(bytes, file.sizeBytes()) ? FileStart::dicom : FileStart::other, ""};
    } catch (const Error& error) {
        const std::string text = error.what();
        const std::size_t colon = text.rfind("found ");
        return {FileStart::notReadable,
                colon == std::string::npos ? "reading it failed" : text.substr(colon + 6)};
    }
}

} // namespace tessera
