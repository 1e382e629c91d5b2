// bricking/store/remote_files.h: RemoteFiles, the files below an address, and the addresses that a program
// can reach. openFolder() (store_files.h) opens what lies below one of them as it opens folders.
#pragma once

#include "core/base/error.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// Bytes of a file.
struct RemoteRange {
    std::string name;
    std::uint64_t offset = 0, bytes = 0;
};

/// What may work later: a server that does not answer.
class OutOfReach : public BadFile {
  public:
    using BadFile::BadFile;
};

/// Thread-safe. Names are relative: joined by '/', none "", "." or ".."; "" is the address as a file.
class RemoteFiles {
  public:
    virtual ~RemoteFiles() = default;
    /// Bytes of a file; nullopt: there is none of that name. Throws OutOfReach naming its address.
    virtual std::optional<std::uint64_t> sizeOf(const std::string& name) = 0;
    /// What the server said where it forbade a file, which then counts as not there: storage that lists no
    /// names says so of all that is not there. "": nothing. Once a file could be read, one that the server
    /// forbids while it forbids that one too is refused.
    virtual std::string whyNone() const = 0;
    /// Fills out from offset. Throws OutOfReach naming its address, InputError when it ends too early or is
    /// no longer the file that it was.
    virtual void readAt(const std::string& name, std::uint64_t offset, std::span<std::byte> out) = 0;
    /// What tells this content of a file from another, as the server says now: "" where nothing is there.
    /// Where the server tells no versions, every run of the program has its own.
    virtual std::string versionOf(const std::string& name) = 0;
    /// What tells the address from others: not for people, and without secrets.
    virtual std::string identity() const = 0;
    /// Most memory that it takes while files are read.
    virtual std::size_t bytesInFlight() const = 0;
    /// Tells that these will be read soon, the first ones first: they are fetched together, before what was
    /// told earlier. A file that is named without bytes is looked for. Failures show when it is read.
    virtual void willRead(std::vector<RemoteRange> ranges) = 0;
    struct Counters {
        std::uint64_t requests = 0, retries = 0, bytesFetched = 0, bytesFromDisk = 0;
    };
    virtual Counters counters() const = 0;
};

/// Where an address below one that can be reached leads.
struct RemotePlace {
    std::shared_ptr<RemoteFiles> files;
    std::string below; // "" or "0/c": before names
    std::string nameOf(const std::string& name) const { return below.empty() ? name : below + "/" + name; }
};

/// From now on openFolder() reaches the address and all below it. Thread-safe.
/// @param address  without secrets (withoutSecrets() of core/base/address.h) and without a '/' at its end
void makeReachable(const std::string& address, std::shared_ptr<RemoteFiles> files);

/// Nullopt: a path that is no address. Throws InputError naming an address that no one made reachable.
std::optional<RemotePlace> remotePlaceOf(const std::filesystem::path& path);

} // namespace tessera
