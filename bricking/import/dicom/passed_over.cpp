// bricking/import/dicom/passed_over.cpp: see passed_over.h.
#include "bricking/import/dicom/passed_over.h"

#include "bricking/import/source/printable_name.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kMostNames = 3;

struct Words {
    const char* key;
    const char* one; // after "1"
    const char* several;
    const char* single; // of one file, after "found"
    bool named;
};
constexpr std::array<Words, 12> kWords = {{
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

const Words& wordsOf(PassedReason reason) {
    return kWords[static_cast<std::size_t>(reason)];
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
        const Words& words = wordsOf(group.first);
        text += (text.empty() ? "" : ", ") + std::to_string(files.size()) + " " +
                (!group.second.empty() ? plural(group.second, files.size())
                 : files.size() == 1   ? words.one
                                       : words.several);
        if (!words.named)
            continue;
        for (std::size_t i = 0; i < std::min(files.size(), kMostNames); ++i)
            text += (i == 0 ? " (" : ", ") + printableName(files[i]->path.filename());
        text += files.size() > kMostNames ? ", ...)" : ")";
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

} // namespace tessera
