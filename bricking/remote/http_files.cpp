// bricking/remote/http_files.cpp: see http_files.h.
#include "bricking/remote/http_files.h"

#include "bricking/remote/block_files.h"
#include "bricking/remote/http_client.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <exception>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stop_token>
#include <string_view>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr std::uint64_t kBlock = kRemoteBlockBytes;
constexpr std::uint64_t kMostBlocksAtOnce = 4; // of one request
constexpr std::size_t kMostFiles = 16384;      // that are known at a time
constexpr std::size_t kFactsBytes = 512;
constexpr std::size_t kMostAhead = 16384;                          // ranges that are told and not yet fetched
constexpr std::size_t kReadersAhead = HttpClient::kMostAtOnce - 2; // who waits for a block has the rest

/// Bytes of a URL that are not letters of it, as %XX.
std::string encoded(const std::string& text, std::string_view plain) {
    std::string out;
    constexpr std::string_view digits = "0123456789ABCDEF";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if ((byte >= '0' && byte <= '9') || (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') ||
            plain.find(c) != std::string_view::npos)
            out += c;
        else
            out += {'%', digits[byte >> 4], digits[byte & 15]};
    }
    return out;
}

/// The address by https of an s3 one.
std::string overHttp(const std::string& address) {
    constexpr std::string_view s3 = "s3://";
    if (!address.starts_with(s3))
        return address;
    const std::string rest = address.substr(s3.size());
    const std::string bucket = rest.substr(0, rest.find('/')), key = rest.substr(bucket.size());
    if (bucket.empty())
        throw badFile(printable(address), "s3://BUCKET/KEY", "no bucket");
    const char* const endpoint = std::getenv("AWS_ENDPOINT_URL");
    if (endpoint && *endpoint) {
        std::string at = endpoint;
        while (at.ends_with('/'))
            at.pop_back();
        return at + "/" + rest;
    }
    if (bucket.find('.') != std::string::npos) // no certificate covers it as a host
        return "https://s3.amazonaws.com/" + rest;
    return "https://" + bucket + ".s3.amazonaws.com" + key;
}

class HttpFiles final : public RemoteFiles {
  public:
    HttpFiles(const std::string& address, const RemoteOptions& options)
        : shown_(withoutSecrets(address)), client_(options.firstWait),
          blocks_(options.blockFolder, options.blockBytes) {
        const std::size_t host = shown_.find("://") + 3;
        if (host >= shown_.size() || shown_[host] == '/')
            throw badFile(printable(shown_), "an address with a host", "none");
        const std::string plain = overHttp(withPlainScheme(address));
        const std::size_t end = std::min(plain.find_first_of("?#"), plain.size());
        const std::string query = plain.substr(end, plain.find('#') - end);
        base_ = encoded(plain.substr(0, end), "-._~:/@!$&'()*+,;=%[]");
        query_ = encoded(query, "-._~:/?@!$&'()*+,;=%");
        for (std::string* text : {&base_, &shown_})
            while (text->ends_with('/'))
                text->pop_back();
        identity_ = withoutSecrets(base_) + "\n" + (query.empty() ? "" : BlockFiles::nameOf(query));
    }
    ~HttpFiles() override {
        client_.stop();
        for (std::jthread& reader : readers_)
            reader.request_stop();
    }

    std::optional<std::uint64_t> sizeOf(const std::string& name) override {
        const std::shared_ptr<File> file = opened(name);
        return file->isThere ? std::optional(file->bytes) : std::nullopt;
    }

    std::string versionOf(const std::string& name) override {
        const std::shared_ptr<File> file = opened(name);
        if (!file->isThere)
            return "";
        const std::string begin = std::to_string(file->bytes) + " ";
        if (!file->version.isSaid())
            return begin + "run " + run_;
        const auto now = client_.get(addressOf(name), shownOf(name), 0, kBlock, file->version);
        if (now && now->isAsKnown)
            return begin + textOf(file->version);
        return now && !now->isForbidden ? std::to_string(now->totalBytes) + " " + textOf(now->version) : "";
    }
    std::string identity() const override { return identity_; }
    std::string whyNone() const override {
        const std::lock_guard lock(mutex_);
        return why_;
    }

    void readAt(const std::string& name, std::uint64_t offset, std::span<std::byte> out) override {
        const std::shared_ptr<File> file = opened(name);
        const std::string shown = shownOf(name);
        if (!file->isThere)
            throw badFile(shown, "a file", "none there");
        if (out.size() > file->bytes || offset > file->bytes - out.size())
            throw badFile(shown, std::to_string(out.size()) + " bytes at offset " + std::to_string(offset),
                          "a file of " + std::to_string(file->bytes));
        if (out.empty())
            return;
        const std::uint64_t end = (offset + out.size() - 1) / kBlock + 1;
        for (std::uint64_t block = offset / kBlock; block < end;) {
            const Run run = nextRun(*file, block, end);
            const Release release{*file, run};
            std::vector<std::byte> bytes(
                static_cast<std::size_t>(std::min(run.end * kBlock, file->bytes) - run.begin * kBlock));
            if (run.end - run.begin > 1 || !kept(*file, run.begin, bytes))
                bytes = fetched(*file, name, run, bytes.size());
            const std::uint64_t from = std::max(offset, run.begin * kBlock),
                                to = std::min(offset + out.size(), run.begin * kBlock + bytes.size());
            std::memcpy(out.data() + (from - offset), bytes.data() + (from - run.begin * kBlock),
                        static_cast<std::size_t>(to - from));
            block = run.end;
        }
    }

    std::size_t bytesInFlight() const override {
        return static_cast<std::size_t>(HttpClient::kMostAtOnce) * kMostBlocksAtOnce * kBlock;
    }
    void willRead(std::vector<RemoteRange> ranges) override {
        if (!blocks_.isUsable() || ranges.empty())
            return;
        const std::lock_guard lock(ahead_.mutex);
        ahead_.wanted.insert(ahead_.wanted.begin(), std::make_move_iterator(ranges.begin()),
                             std::make_move_iterator(ranges.end()));
        if (ahead_.wanted.size() > kMostAhead)
            ahead_.wanted.resize(kMostAhead);
        while (readers_.size() < kReadersAhead)
            readers_.emplace_back([this](const std::stop_token& stop) { readAhead(stop); });
        ahead_.news.notify_all();
    }
    Counters counters() const override {
        return {client_.requests(), client_.retries(), client_.bytesFetched(), fromDisk_};
    }

  private:
    struct File {
        std::mutex opening; // held while the server is asked for it the first time
        bool isKnown = false, isThere = false;
        std::uint64_t bytes = 0;
        HttpVersion version;
        std::string key; // of its blocks, before their numbers
        std::mutex mutex;
        std::condition_variable loaded;
        std::set<std::uint64_t> loading; // blocks that a thread reads or fetches
        // The last failure, for which others need not wait again for a while.
        std::exception_ptr failure;
        std::chrono::steady_clock::time_point failedUntil;
    };
    struct Run {
        std::uint64_t begin = 0, end = 0; // blocks
    };
    /// Lets others have the blocks of a run.
    struct Release {
        File& file;
        Run run;
        ~Release() {
            const std::lock_guard lock(file.mutex);
            for (std::uint64_t block = run.begin; block < run.end; ++block)
                file.loading.erase(block);
            file.loaded.notify_all();
        }
    };

    std::string shownOf(const std::string& name) const {
        return printable(name.empty() ? shown_ : shown_ + "/" + name);
    }
    std::string addressOf(const std::string& name) const {
        return base_ + (name.empty() ? "" : "/" + encoded(name, "-._~/")) + query_;
    }

    /// A file with what the server says of it: by its first block, which most small files are.
    std::shared_ptr<File> opened(const std::string& name) {
        std::shared_ptr<File> file;
        {
            const std::lock_guard lock(mutex_);
            if (files_.size() >= kMostFiles) // those that no one reads are asked for again
                std::erase_if(files_, [](const auto& each) { return each.second.use_count() == 1; });
            std::shared_ptr<File>& entry = files_[name];
            if (!entry)
                entry = std::make_shared<File>();
            file = entry;
        }
        const std::lock_guard lock(file->opening);
        if (file->isKnown)
            return file;
        const std::optional<Facts> known = factsOf(name);
        auto part = answerOf(*file, name, 0, kBlock, known ? known->version : HttpVersion());
        if (part && part->isForbidden) {
            requireWitness(name);
            part.reset();
        }
        if (part && part->isAsKnown) {
            describe(*file, name, *known);
        } else if (part) {
            describe(*file, name, {part->totalBytes, part->version});
            if (part->bytes.size() != std::min(part->totalBytes, kBlock))
                throw badFile(shownOf(name), "the first bytes of the file", "others");
            blocks_.write(keyOf(*file, 0), part->bytes);
            keepFacts(name, {part->totalBytes, part->version});
        }
        file->isKnown = true;
        if (file->isThere)
            noteWitness(name);
        return file;
    }

    /// A file that could be read, and shows whether the server still lets this program read.
    void noteWitness(const std::string& name) {
        const std::lock_guard lock(mutex_);
        witness_ = name;
    }
    /// After a 403. Throws InputError where the server forbids all.
    void requireWitness(const std::string& name) {
        std::string witness;
        {
            const std::lock_guard lock(mutex_);
            why_ = "403 for " + shownOf(name) + ": forbidden, or not there";
            if (witness_.empty())
                return;
            witness = witness_;
        }
        const auto part = client_.get(addressOf(witness), shownOf(witness), 0, 1);
        if (part && part->isForbidden)
            throw badFile(shownOf(name), "a file that may be read", "a server that forbids it (403)");
    }

    /// What a server said of a file.
    struct Facts {
        std::uint64_t bytes = 0;
        HttpVersion version;
    };
    static std::string textOf(const HttpVersion& version) { return version.tag + "\t" + version.date; }

    /// Remembers a failure for a while, so that many who want a file do not try in vain one after another.
    std::optional<HttpPart> answerOf(File& file, const std::string& name, std::uint64_t offset,
                                     std::size_t count, const HttpVersion& known) {
        using Clock = std::chrono::steady_clock;
        {
            const std::lock_guard lock(file.mutex);
            if (file.failure && Clock::now() < file.failedUntil)
                std::rethrow_exception(file.failure);
        }
        try {
            return client_.get(addressOf(name), shownOf(name), offset, count, known);
        } catch (const InputError&) {
            const std::lock_guard lock(file.mutex);
            file.failure = std::current_exception();
            file.failedUntil = Clock::now() + HttpClient::kPause;
            throw;
        }
    }
    void describe(File& file, const std::string& name, const Facts& facts) const {
        file.isThere = true;
        file.bytes = facts.bytes;
        file.version = facts.version;
        // Without a version blocks are of this run alone.
        file.key = identity_ + "/" + name + "\n" + std::to_string(facts.bytes) + "\n" +
                   (facts.version.isSaid() ? textOf(facts.version) : "run " + run_);
    }
    std::string factsKey(const std::string& name) const { return identity_ + "/" + name + "\nfacts"; }
    /// Those of an earlier run; its blocks are good if the server still says the same.
    std::optional<Facts> factsOf(const std::string& name) {
        std::array<char, kFactsBytes> text{};
        if (!blocks_.read(factsKey(name), std::as_writable_bytes(std::span(text))))
            return std::nullopt;
        Facts facts;
        const std::string_view all(text.data(), strnlen(text.data(), text.size()));
        const std::size_t blank = all.find(' '), tab = all.rfind('\t');
        if (blank == std::string_view::npos || tab == std::string_view::npos || tab < blank)
            return std::nullopt;
        std::from_chars(all.data(), all.data() + blank, facts.bytes);
        facts.version = {std::string(all.substr(blank + 1, tab - blank - 1)),
                         std::string(all.substr(tab + 1))};
        return facts;
    }
    void keepFacts(const std::string& name, const Facts& facts) {
        const std::string line = std::to_string(facts.bytes) + " " + textOf(facts.version);
        std::array<char, kFactsBytes> text{};
        if (!facts.version.isSaid() || line.size() >= text.size())
            return;
        std::copy(line.begin(), line.end(), text.begin());
        blocks_.write(factsKey(name), std::as_bytes(std::span(text)));
    }

    static std::string keyOf(const File& file, std::uint64_t block) {
        return file.key + "\n" + std::to_string(block);
    }

    /// The next blocks to take, from `block`: those that no other thread is at, up to the first one that is
    /// kept; or one that is kept.
    Run nextRun(File& file, std::uint64_t block, std::uint64_t end) {
        std::unique_lock lock(file.mutex);
        file.loaded.wait(lock, [&] { return !file.loading.contains(block); });
        Run run{block, block};
        while (run.end < std::min(end, block + kMostBlocksAtOnce) && !file.loading.contains(run.end)) {
            const bool isKept = blocks_.has(keyOf(file, run.end));
            if (isKept && run.end > block)
                break;
            file.loading.insert(run.end++);
            if (isKept)
                break;
        }
        return run;
    }

    bool kept(const File& file, std::uint64_t block, std::span<std::byte> out) {
        if (!blocks_.read(keyOf(file, block), out))
            return false;
        fromDisk_ += out.size();
        return true;
    }

    /// Fetches what was told, until the object goes.
    void readAhead(const std::stop_token& stop) {
        while (true) {
            RemoteRange next;
            {
                std::unique_lock lock(ahead_.mutex);
                if (!ahead_.news.wait(lock, stop, [&] { return !ahead_.wanted.empty(); }) ||
                    stop.stop_requested())
                    return;
                next = std::move(ahead_.wanted.front());
                ahead_.wanted.pop_front();
            }
            try {
                keep(next);
            } catch (const std::exception&) { // told to who reads it
            }
        }
    }

    /// Has the blocks of a range on disk.
    void keep(const RemoteRange& range) {
        const std::shared_ptr<File> file = opened(range.name);
        if (!file->isThere || range.bytes == 0 || range.offset >= file->bytes)
            return;
        const std::uint64_t last = std::min(file->bytes, range.offset + range.bytes) - 1;
        const std::uint64_t end = last / kBlock + 1;
        for (std::uint64_t block = range.offset / kBlock; block < end;) {
            const Run run = nextRun(*file, block, end);
            const Release release{*file, run};
            if (run.end - run.begin > 1 || !blocks_.has(keyOf(*file, run.begin)))
                fetched(
                    *file, range.name, run,
                    static_cast<std::size_t>(std::min(run.end * kBlock, file->bytes) - run.begin * kBlock));
            block = run.end;
        }
    }

    std::vector<std::byte> fetched(File& file, const std::string& name, const Run& run, std::size_t count) {
        auto part = answerOf(file, name, run.begin * kBlock, count, {});
        if (part && part->isForbidden)
            throw badFile(shownOf(name), "a file that may be read", "a server that forbids it (403)");
        if (!part || part->totalBytes != file.bytes || !part->version.isThatOf(file.version) ||
            part->bytes.size() != count)
            throw badFile(shownOf(name), "the file that it was when it was opened", "another");
        for (std::uint64_t block = run.begin; block < run.end; ++block) {
            const std::size_t at = static_cast<std::size_t>((block - run.begin) * kBlock);
            blocks_.write(keyOf(file, block),
                          std::span(part->bytes).subspan(at, std::min<std::size_t>(kBlock, count - at)));
        }
        return std::move(part->bytes);
    }

    std::string shown_, base_, query_, identity_;
    std::string run_ =
        std::to_string(::getpid()) + " " +
        std::to_string(std::chrono::system_clock::now().time_since_epoch().count()); // this one
    HttpClient client_;
    BlockFiles blocks_;
    mutable std::mutex mutex_;
    std::map<std::string, std::shared_ptr<File>> files_;
    std::string witness_, why_;
    std::atomic<std::uint64_t> fromDisk_{0};
    struct {
        std::mutex mutex;
        std::condition_variable_any news;
        std::deque<RemoteRange> wanted;
    } ahead_;
    std::vector<std::jthread> readers_; // the last member: they end first
};

} // namespace

std::shared_ptr<RemoteFiles> openRemoteFiles(const std::string& address, const RemoteOptions& options) {
    return std::make_shared<HttpFiles>(address, options);
}

} // namespace tessera
