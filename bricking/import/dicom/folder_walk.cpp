// bricking/import/dicom/folder_walk.cpp: see folder_walk.h.
#include "bricking/import/dicom/folder_walk.h"

#include "bricking/import/source/source_files.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kMostFiles = 3;

struct ReasonWords {
    const char* key;
    const char* one; // after "1"
    const char* several;
    const char* single; // of one file, after "found"
    bool named;
};
constexpr std::array<ReasonWords, 12> kReasonWords = {{
    {"notSlice", "file of another kind", "files of other kinds", "a file of another kind", true},
    {"notDicom", "not DICOM", "not DICOM", "a file that is not DICOM", true},
    {"empty", "empty", "empty", "an empty file (0 bytes)", true},
    {"zeroFilled", "filled with zeros", "filled with zeros", "a file filled with zeros", true},
    {"notReadable", "not readable", "not readable", "a file that is not readable", true},
    {"emptyFolder", "empty folder", "empty folders", "an empty folder", true},
    {"folderNotReadable", "folder not readable", "folders not readable", "a folder that is not readable",
     true},
    {"folderLink", "link to a folder, not followed", "links to folders, not followed", "a link to a folder",
     true},
    {"damaged", "damaged or not decodable", "damaged or not decodable", "a damaged file", true},
    {"notImage", "", "", "", false},
    {"noPlace", "", "", "", false},
    {"zarr", "Zarr folder", "Zarr folders", "a Zarr folder", true},
}};

const ReasonWords& wordsOf(PassedReason reason) {
    return kReasonWords[static_cast<std::size_t>(reason)];
}

/// "3 dose reports", "2 images without a position in the patient"
std::string plural(const std::string& what, std::size_t count) {
    const std::string noun = what.substr(0, std::min(what.find(" with"), what.find(" not ")));
    return count == 1 ? what : noun + "s" + what.substr(noun.size());
}

} // namespace

std::string countPassed(const std::vector<PassedFile>& passed) {
    std::map<std::pair<PassedReason, std::string>, std::vector<const PassedFile*>> groups;
    for (const PassedFile& file : passed) {
        const bool byKind = file.reason == PassedReason::notImage || file.reason == PassedReason::noPlace;
        groups[{file.reason, byKind ? file.found : ""}].push_back(&file);
    }
    std::string text;
    for (const auto& [group, files] : groups) {
        const ReasonWords& words = wordsOf(group.first);
        text += (text.empty() ? "" : ", ") + std::to_string(files.size()) + " " +
                (!group.second.empty() ? plural(group.second, files.size())
                 : files.size() == 1   ? words.one
                                       : words.several);
        if (!words.named)
            continue;
        for (std::size_t i = 0; i < std::min(files.size(), kMostFiles); ++i)
            text += (i == 0 ? " (" : ", ") + printableName(files[i]->path.filename());
        text += files.size() > kMostFiles ? ", ...)" : ")";
    }
    return text;
}

std::string foundIn(const PassedFile& file) {
    switch (file.reason) {
    case PassedReason::damaged:
    case PassedReason::notImage:
    case PassedReason::noPlace:
        return file.found;
    case PassedReason::notReadable:
    case PassedReason::folderNotReadable:
        return wordsOf(file.reason).single + (file.found.empty() ? "" : " (" + file.found + ")");
    default:
        return wordsOf(file.reason).single;
    }
}

const char* keyOf(PassedReason reason) {
    return wordsOf(reason).key;
}

// Elements as in DICOM PS3.5, chapter 7: tag, (VR,) length.

namespace {

constexpr int kEnough = 4; // elements that fit; by chance one in 2^60 files does
constexpr std::array<std::string_view, 34> kKnownRepresentations = {
    "AE", "AS", "AT", "CS", "DA", "DS", "DT", "FD", "FL", "IS", "LO", "LT", "OB", "OD", "OF", "OL", "OV",
    "OW", "PN", "SH", "SL", "SQ", "SS", "ST", "SV", "TM", "UC", "UI", "UL", "UN", "UR", "US", "UT", "UV"};
constexpr std::array<std::string_view, 13> kLong = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                                    "SV", "UC", "UN", "UR", "UT", "UV"};

std::uint32_t number(std::span<const std::byte> head, std::size_t at, int bytes) {
    std::uint32_t value = 0;
    for (int i = bytes - 1; i >= 0; --i)
        value = value << 8 | std::to_integer<std::uint32_t>(head[at + static_cast<std::size_t>(i)]);
    return value;
}

} // namespace

bool looksLikeBareDicom(std::span<const std::byte> head, std::uint64_t fileBytes) {
    std::size_t at = 0;
    std::uint32_t before = 0;
    bool isExplicit = false;
    for (int elements = 0; elements < kEnough; ++elements) {
        if (at + 12 > head.size())
            return elements > 0 && at < fileBytes && head.size() < fileBytes;
        const std::uint32_t group = number(head, at, 2), tag = group << 16 | number(head, at + 2, 2);
        const bool groupFits = group == 0x0002 || group == 0x0008;
        if (!groupFits || (elements > 0 && tag <= before))
            return elements > 0 && group > 0x0008 && group <= 0x0020 && tag > before;
        const std::string_view vr(reinterpret_cast<const char*>(head.data()) + at + 4, 2);
        const bool known = std::find(kKnownRepresentations.begin(), kKnownRepresentations.end(), vr) !=
                           kKnownRepresentations.end();
        if (elements == 0 || (before >> 16 == 0x0002 && group == 0x0008)) // group 2 is always explicit
            isExplicit = known;
        if (isExplicit != known)
            return false;
        std::size_t valueAt = at + 8;
        std::uint64_t length = number(head, at + 4, 4);
        if (isExplicit) {
            const bool isLong = std::find(kLong.begin(), kLong.end(), vr) != kLong.end();
            length = isLong ? number(head, at + 8, 4) : number(head, at + 6, 2);
            valueAt = at + (isLong ? 12 : 8);
        }
        if (length == 0xffffffff)
            return elements > 0; // a sequence of unknown length
        if (length % 2 != 0 || valueAt + length > fileBytes)
            return false;
        before = tag;
        at = valueAt + static_cast<std::size_t>(length);
    }
    return true;
}

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
