// viewer/cli/input/source_facts.cpp: see source_facts.h.
#include "viewer/cli/input/source_facts.h"

#include "bricking/import/importer.h" // kImportVersion
#include "bricking/store/remote_files.h"
#include "bricking/store/store_files.h"
#include "viewer/cli/input/remote_input.h"
#if TESSERA_WITH_IMPORT
#include "bricking/import/catalogue.h"
#endif

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <sys/stat.h>
#include <system_error>
#include <vector>

namespace tessera {
namespace fs = std::filesystem;

std::string hexHash(const std::string& text, std::uint64_t start) {
    std::uint64_t h = start;
    for (const char c : text)
        h = (h ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
    char hex[kHashDigits + 1];
    std::snprintf(hex, sizeof hex, "%016llx", static_cast<unsigned long long>(h));
    return hex;
}

std::string hexCheck(const std::string& text) {
    return hexHash(text, 0x9E3779B97F4A7C15u);
}

std::string factsOf(const fs::path& path, const std::string& leftOut) {
    std::vector<std::string> files;
    const auto add = [&](const fs::path& file) {
        struct stat facts {};
        if (::stat(file.c_str(), &facts) != 0 || !S_ISREG(facts.st_mode) ||
            (!leftOut.empty() && file.lexically_relative(path).string().starts_with(leftOut)))
            return;
        const auto time = [](const timespec& t) {
            return "|" + std::to_string(t.tv_sec) + "." + std::to_string(t.tv_nsec);
        };
        files.push_back(file.lexically_relative(path).string() + "|" + std::to_string(facts.st_ino) + "|" +
                        std::to_string(facts.st_size) + time(facts.st_mtim) + time(facts.st_ctim));
    };
    std::error_code ignored;
    if (fs::is_directory(path, ignored))
        for (fs::recursive_directory_iterator
                 entry(path, fs::directory_options::skip_permission_denied, ignored),
             end;
             !ignored && entry != end; entry.increment(ignored))
            if (nameOfUnfinishedFolder(entry->path().filename().string()))
                entry.disable_recursion_pending();
            else
                add(entry->path());
    else
        add(path);
    std::sort(files.begin(), files.end()); // the order of a listing is unspecified
    std::string text;
    for (const std::string& file : files)
        text += file + "\n";
    return text;
}

std::string factsOfSource(const fs::path& path) {
    const fs::path given = reached(path);
    if (const auto place = remotePlaceOf(given)) { // of its metadata: chunks may be millions
        std::string versions = place->files->identity() + "\n" + place->below + "\n";
        bool isZarr = false;
        for (const char* name : {"zarr.json", ".zattrs", ".zarray", "0/zarr.json", "0/.zarray"}) {
            const std::string version = place->files->versionOf(place->nameOf(name));
            isZarr = isZarr || !version.empty();
            versions += name + ("|" + version) + "\n";
        }
        if (!isZarr)
            versions += "itself|" + place->files->versionOf(place->below) + "\n";
#if TESSERA_WITH_IMPORT
        for (const fs::path& named : namedFilesOf(given))
            if (const auto part = remotePlaceOf(named); part && !part->below.empty())
                versions += part->below + "|" + part->files->versionOf(part->below) + "\n";
#endif
        return versions;
    }
    std::error_code missing;
    const fs::path whole = fs::canonical(given, missing);
    if (missing) // opening it says why
        return {};
    std::string facts = factsOf(whole);
#if TESSERA_WITH_IMPORT
    for (const fs::path& named : namedFilesOf(given))
        facts += factsOf(named);
#endif
    return facts;
}

std::string importKey(const fs::path& given, const std::string& options) {
    const std::string text = std::to_string(kImportVersion) + "\n" + options + "\n" + factsOfSource(given);
    return hexHash(text) + hexCheck(text);
}

} // namespace tessera
