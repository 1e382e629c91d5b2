// bricking/remote/http_files.h: the files below an address on a server, read in blocks, which are kept on
// disk.
#pragma once

#include "bricking/store/remote_files.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace tessera {

struct RemoteOptions {
    std::filesystem::path blockFolder = {};  // of blocks that are kept; "": none are
    std::uint64_t blockBytes = 0;            // at most, of all blocks in it
    std::chrono::milliseconds firstWait{50}; // before a request is made again; then twice as long
};

/// Bytes that are fetched and kept as one.
constexpr std::size_t kRemoteBlockBytes = std::size_t{128} << 10;

/// @param address  http://, https:// or s3://BUCKET/KEY, which is read without a key: from
///     $AWS_ENDPOINT_URL/BUCKET/KEY if that is set, else from Amazon. User, password and query go with every
///     request, and into no message
/// Nothing is fetched yet. Throws InputError for an address without a host.
std::shared_ptr<RemoteFiles> openRemoteFiles(const std::string& address, const RemoteOptions& options);

} // namespace tessera
