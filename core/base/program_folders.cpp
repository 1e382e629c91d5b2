// core/base/program_folders.cpp: see program_folders.h.
#include "core/base/program_folders.h"

#include "core/base/error.h"
#include "core/base/ownership.h"
#include "core/base/shown_text.h"

#include <cstdlib>
#include <random>

namespace tessera {
namespace {

constexpr const char* kPrefix = "tessera-scratch-";
constexpr std::size_t kLetters = 8;

std::string randomName() {
    static constexpr char kAlphabet[] = "abcdefghijklmnopqrstuvwxyz0123456789";
    std::random_device random;
    std::uniform_int_distribution<std::size_t> letter(0, sizeof kAlphabet - 2);
    std::string name = kPrefix;
    for (std::size_t i = 0; i < kLetters; ++i)
        name += kAlphabet[letter(random)];
    return name;
}

bool isScratchName(const std::string& name) {
    const std::string_view prefix = kPrefix;
    return name.size() == prefix.size() + kLetters && name.starts_with(prefix);
}

} // namespace

ScratchFolder::ScratchFolder() {
    std::error_code error;
    const std::filesystem::path place = std::filesystem::temp_directory_path(error);
    if (error)
        throw Error("temporary folder (TMPDIR): " + error.message());
    sweepLeftovers(place, isScratchName);
    constexpr int kTries = 100;
    for (int i = 0; i < kTries; ++i) {
        path_ = place / randomName();
        if (auto made = makeOwnFolder(path_, 0700)) {
            owned_ = std::move(*made);
            unfinished_.emplace(path_);
            return;
        }
    }
    throw Error(printable(place.string()) + ": cannot make a temporary folder: no name is free");
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path userConfigFolder() {
    const char* const config = std::getenv("XDG_CONFIG_HOME");
    const char* const home = std::getenv("HOME");
    if (config && *config == '/')
        return std::filesystem::path(config) / "tessera";
    if (home && *home == '/')
        return std::filesystem::path(home) / ".config" / "tessera";
    return {};
}

} // namespace tessera
