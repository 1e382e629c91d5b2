// bricking/validate/validate_store.cpp: see validate_store.h.
#include "bricking/validate/validate_store.h"

#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h"
#include "bricking/store/zarr_metadata.h"
#include "bricking/validate/kept_parts.h"
#include "bricking/validate/leftovers.h"
#include "bricking/validate/store_faults.h"
#include "bricking/validate/stored_levels.h"
#include "bricking/validate/written_place.h"
#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/base/ownership.h"
#include "core/base/shown_text.h"

#include <cerrno>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <unistd.h> // access

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr const char* kGroup = "zarr.json";

/// One run of validateStore().
class Validation {
  public:
    Validation(const fs::path& path, MemoryBudget& ram, const ValidateOptions& options)
        : path_(path), ram_(ram), options_(options), folder_(openFolder(path)) {}

    ValidateReport run();

  private:
    void lock();
    std::optional<StoreMetadata> readGroup();
    void checkDocument(const std::string& relative, const std::string& expected,
                       const std::function<void(const std::string& text)>& check);
    void mendDocument(const std::string& relative, const std::string& text);
    void checkDocuments(const StoreMetadata& metadata);
    void checkLevels(const StoreMetadata& metadata);
    void checkKept(const StoreMetadata& metadata);
    void checkLeftovers();
    void stage(const char* what) const {
        if (options_.progress)
            options_.progress->stage(what + printable(path_.filename().string()));
    }
    ShareDone shares() const { return options_.progress ? options_.progress->shares() : ShareDone{}; }

    fs::path path_;
    MemoryBudget& ram_;
    const ValidateOptions& options_;
    StoreFolder folder_;
    LockTry lock_;
    StoreFaults faults_;
    ValidateReport report_;
    bool mends_ = false, areLevelsWhole_ = false;
};

/// No other process may be replacing, making or mending the store.
void Validation::lock() {
    lock_ = tryLock(path_, options_.repair ? LockKind::exclusive : LockKind::shared);
    if (lock_.busy)
        throw badFile(path_.string(), "a store that no other process writes",
                      "one that is being written, replaced or repaired");
    mends_ = options_.repair;
    if (mends_ && ::access(path_.c_str(), W_OK | X_OK) != 0) {
        report_.notes.push_back("nothing is repaired: " + printable(path_.string()) +
                                " cannot be written: " + std::strerror(errno));
        mends_ = false;
    }
}

/// The group's document: without it nothing else is known.
std::optional<StoreMetadata> Validation::readGroup() {
    const std::string where = (path_ / kGroup).string();
    const auto isNoStore = [&](const std::string& found) {
        return badFile(path_.string(), "a store of Tessera", found);
    };
    std::optional<std::string> text;
    try {
        text = readText(folder_, kGroup, path_, kMaxMetadataBytes);
        if (!text) {
            if (!openIn(folder_, "0/zarr.json", path_))
                throw isNoStore("a folder without zarr.json");
            throw badFile(where, "the metadata of a store", "no such file");
        }
    } catch (const BadFile& problem) {
        if (problem.expected() == "a store of Tessera")
            throw;
        faults_.add(kGroup, problem.what());
        return std::nullopt;
    }
    if (!isGroupOfOurs(*text) && text->find("tessera") == std::string::npos &&
        text->find("levelRule") == std::string::npos && text->find("zarr_format") != std::string::npos)
        throw isNoStore("a Zarr group of another program");
    try {
        StoreMetadata metadata = parseGroup(*text, where);
        checkDocument(kGroup, groupDocument(metadata), [](const std::string&) {});
        return metadata;
    } catch (const BadFile& problem) {
        faults_.add(kGroup, problem.what());
        return std::nullopt;
    }
}

/// A document whose text is known. `check` finds what differs; else it is white space.
void Validation::checkDocument(const std::string& relative, const std::string& expected,
                               const std::function<void(const std::string&)>& check) {
    const std::string where = (path_ / relative).string();
    try {
        const auto text = readText(folder_, relative, path_, kMaxMetadataBytes);
        if (!text)
            throw badFile(where, "the metadata of a store", "no such file");
        if (*text == expected)
            return;
        check(*text);
        throw badFile(where, "the text that its content gives", "other white space, or another order");
    } catch (const BadFile& problem) {
        faults_.add(relative, problem.what());
    }
    if (mends_)
        mendDocument(relative, expected);
}

void Validation::mendDocument(const std::string& relative, const std::string& text) {
    try {
        if (const std::string why = whyNotWritten(path_, relative); !why.empty())
            return faults_.leave(relative, why);
        fs::create_directories((path_ / relative).parent_path());
        writeOutputFile(path_ / relative, text);
        faults_.mend(relative);
    } catch (const Error& problem) {
        faults_.leave(relative, problem.what());
    } catch (const fs::filesystem_error& problem) {
        faults_.leave(relative, problem.code().message());
    }
}

void Validation::checkDocuments(const StoreMetadata& metadata) {
    for (int level = 0; level < kLevelCount; ++level) {
        const std::string relative = std::to_string(level) + "/zarr.json";
        checkDocument(relative, levelDocument(metadata, level), [&](const std::string& text) {
            checkLevel(text, metadata, level, (path_ / relative).string());
        });
    }
}

void Validation::checkLevels(const StoreMetadata& metadata) {
    StoredLevels levels(path_, metadata, ram_, options_.threads, faults_);
    stage("checking ");
    levels.check(shares());
    if (levels.isWithoutRule())
        report_.notes.push_back("levels of labels could not be compared: by their rule they depend on all of "
                                "level 0, which is damaged");
    if (mends_ && !levels.areWhole()) {
        stage("repairing ");
        levels.repair(shares());
    }
    areLevelsWhole_ = levels.areWhole();
    report_.shards = levels.shards();
    report_.chunks = levels.chunks();
}

void Validation::checkKept(const StoreMetadata& metadata) {
    for (int level = 0; level < kLevelCount; ++level)
        if (faults_.has(std::to_string(level) + "/zarr.json") && !mends_) {
            report_.notes.push_back("statistics were not checked, because the metadata of a level is wrong");
            return;
        }
    std::optional<StoreReader> store;
    try {
        store.emplace(path_, ram_);
    } catch (const BadFile& problem) { // a document that could not be mended
        report_.notes.push_back(std::string("statistics were not checked: ") + problem.what());
        return;
    }
    stage("checking statistics of ");
    KeptParts kept(*store, ram_, options_.threads, faults_, report_.notes);
    if (metadata.rule == kMajorityRule) {
        kept.checkLabels();
        if (options_.thorough && areLevelsWhole_)
            kept.compareLabels();
        return;
    }
    kept.check();
    if (options_.thorough && areLevelsWhole_)
        kept.compare(shares());
    if (mends_)
        kept.repair(areLevelsWhole_, shares());
}

void Validation::checkLeftovers() {
    for (const fs::path& leftover : leftoversOf(path_)) {
        const std::string part = leftover.string();
        faults_.add(part,
                    badFile(part, "no unfinished file", "one that a process left when it was killed").what());
        if (!mends_)
            continue;
        if (removeLeftover(leftover))
            faults_.mend(part);
        else
            faults_.leave(part, "it could not be removed");
    }
}

ValidateReport Validation::run() {
    lock();
    checkLeftovers();
    if (const auto metadata = readGroup()) {
        checkDocuments(*metadata);
        checkLevels(*metadata);
        checkKept(*metadata);
        if (mends_ && faults_.has(kGroup))
            faults_.leave(kGroup, "what it says of level 0 is told by an import alone");
    } else {
        report_.notes.push_back("nothing else was checked, because all follows from the group's zarr.json");
        if (mends_)
            faults_.leave(kGroup, "it is made by an import alone");
    }
    report_.lines = faults_.lines();
    report_.faults = faults_.count();
    report_.mended = faults_.mended();
    return report_;
}

} // namespace

ValidateReport validateStore(const fs::path& path, MemoryBudget& ram, const ValidateOptions& options) {
    return Validation(path, ram, options).run();
}

} // namespace tessera
