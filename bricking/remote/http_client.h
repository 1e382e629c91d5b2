// bricking/remote/http_client.h: HttpClient: parts of what lies at an address, by GET with a range of bytes.
// Requests that fail for a while are tried again, later and later.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// What a server says of the content at an address: either or none may be "".
struct HttpVersion {
    std::string tag, date; // ETag, Last-Modified
    bool isSaid() const { return !tag.empty() || !date.empty(); }
    /// By the tags where both have one: servers of one address may have files of several dates.
    bool isThatOf(const HttpVersion& other) const {
        return tag.empty() || other.tag.empty() ? date == other.date : tag == other.tag;
    }
};

/// What lies at an address.
struct HttpPart {
    std::uint64_t totalBytes = 0; // of the whole
    HttpVersion version;
    std::vector<std::byte> bytes; // from the offset that was asked for; fewer at the end of the whole
    bool isAsKnown = false;       // it is the known version: nothing else is said of it
    bool isForbidden = false;     // 403: nothing else is said of it
};

class HttpClient {
  public:
    static constexpr int kMostAtOnce = 16; // requests; more wait

    /// @param firstWait  before the second try; then twice as long
    explicit HttpClient(std::chrono::milliseconds firstWait);
    ~HttpClient();
    HttpClient(const HttpClient&) = delete;
    HttpClient& operator=(const HttpClient&) = delete;

    /// Bytes from offset to the end or `count` of them. Thread-safe. TLS certificates are verified; redirects
    /// lead from https to https alone.
    /// @param shown  the address for messages
    /// @param known  a version that need not be sent again
    /// @return nullopt: there is nothing at the address (404, 410)
    /// Throws InputError naming `shown` for other answers; OutOfReach after all tries, of which none begins
    /// after kMostSeconds; Interrupted and Cancelled as checkInterrupted() does, and Cancelled after
    /// stop(). A server that did not answer at all is not asked again for kPause.
    std::optional<HttpPart> get(const std::string& address, const std::string& shown, std::uint64_t offset,
                                std::size_t count, const HttpVersion& known = {});
    /// Ends requests of all threads.
    void stop() { isStopped_ = true; }

    std::uint64_t requests() const { return requests_; }
    std::uint64_t retries() const { return retries_; }
    std::uint64_t bytesFetched() const { return bytes_; }

    static constexpr int kTries = 8;
    static constexpr std::chrono::seconds kPause{10}, kMostSeconds{60};

  private:
    struct Try;
    class Handle;
    Try attempt(const std::string& address, std::uint64_t offset, std::size_t count,
                const HttpVersion& known);
    void wait(std::chrono::milliseconds time) const;
    void checkStopped() const;

    struct Pool;
    std::chrono::milliseconds firstWait_;
    std::unique_ptr<Pool> pool_; // connections that stay open
    std::mutex mutex_;
    std::chrono::steady_clock::time_point silentUntil_{}; // of a server that did not answer
    std::string why_;
    std::atomic<bool> isStopped_{false};
    std::atomic<std::uint64_t> requests_{0}, retries_{0}, bytes_{0};
};

} // namespace tessera
