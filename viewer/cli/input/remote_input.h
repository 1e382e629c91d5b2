// viewer/cli/input/remote_input.h: volumes behind addresses (https://, http://, s3://), where commands take
// paths.
#pragma once

#include "bricking/store/store_reader.h"

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// Makes an address reachable for this process. Nothing is fetched yet. What is fetched later is kept in
/// remoteBlockFolder() (import_cache.h), a quarter of cacheLimitBytes() at most.
/// @return the path to open it by: the address without what may be secret; other paths as they are
/// Throws InputError when this program was built without it.
std::filesystem::path reached(const std::filesystem::path& path);

/// Bytes that blocks from servers may take on disk.
std::uint64_t remoteBytesLimit();

/// The words of a command, with reached() for addresses, also behind "--option=": so nothing that may be
/// secret gets farther, into messages for example. Throws as reached() does.
std::vector<std::string> reachedWords(std::span<char* const> words);

/// What was asked of servers for stores behind addresses, for people; "": there are none.
std::string sayFetched(Stores stores);

} // namespace tessera
