// bricking/remote/block_files.h: BlockFiles, blocks of remote files on disk, each a file with a checksum,
// within a budget of bytes. Processes may share the folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <list>
#include <mutex>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace tessera {

class BlockFiles {
  public:
    /// Makes the folder where it is missing, readable by its owner only. Where that fails nothing is kept.
    /// @param limitBytes  of all blocks; the oldest go first. Other processes that write there at the same
    ///     time may exceed it by what they write
    BlockFiles(std::filesystem::path folder, std::uint64_t limitBytes);

    /// Fills out with a block that was kept. Thread-safe.
    /// @param key  tells the block from all others, also from those of a file's other versions
    /// @return false if there is none, or a damaged or shorter one, which is removed
    bool read(const std::string& key, std::span<std::byte> out);
    /// True if one is noted; reading it may yet fail. Thread-safe.
    bool has(const std::string& key) const;
    /// Keeps a block; silently does not where the disk is full. Thread-safe.
    void write(const std::string& key, std::span<const std::byte> block);

    /// Digits that no other key has, by all odds.
    static std::string nameOf(const std::string& key);

    bool isUsable() const { return isUsable_ && limit_ > 0; }

  private:
    struct Kept {
        std::string name;
        std::uint64_t bytes = 0;
    };
    void note(const std::string& name, std::uint64_t bytes);
    void makeRoom();
    std::filesystem::path pathOf(const std::string& name) const;

    std::filesystem::path folder_;
    std::uint64_t limit_;
    bool isUsable_ = false;
    mutable std::mutex mutex_;
    std::list<Kept> kept_; // oldest first
    std::unordered_map<std::string, std::list<Kept>::iterator> found_;
    std::uint64_t bytes_ = 0;
};

} // namespace tessera
