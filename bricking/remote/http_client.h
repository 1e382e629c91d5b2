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

/// What lies at an address.
struct HttpPart {
    std::uint64_t totalBytes = 0; // of the whole
    std::string version;          // ETag, else Last-Modified; "" the server says neither
    std::vector<std::byte> bytes; // from the offset that was asked for; fewer at the end of the whole
    bool isAsKnown = false;       // it is the known version: nothing else is said of it
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
    /// @param known  a version that need not be sent again; "" none
    /// @return nullopt: there is nothing at the address (404, 410)
    /// Throws InputError naming `shown` when it is refused (403 and other answers), or out of reach after all
    /// tries; Interrupted and Cancelled as checkInterrupted() does. A server that did not answer at all is
    /// not asked again for kPause.
    std::optional<HttpPart> get(const std::string& address, const std::string& shown, std::uint64_t offset,
                                std::size_t count, const std::string& known = {});

    std::uint64_t requests() const { return requests_; }
    std::uint64_t retries() const { return retries_; }
    std::uint64_t bytesFetched() const { return bytes_; }

    static constexpr int kTries = 8;
    static constexpr std::chrono::seconds kPause{10};

  private:
    struct Try;
    class Handle;
    Try attempt(const std::string& address, std::uint64_t offset, std::size_t count,
                const std::string& known);
    void wait(std::chrono::milliseconds time) const;

    struct Pool;
    std::chrono::milliseconds firstWait_;
    std::unique_ptr<Pool> pool_; // connections that stay open
    std::mutex mutex_;
    std::chrono::steady_clock::time_point silentUntil_{}; // of a server that did not answer
    std::string why_;
    std::atomic<std::uint64_t> requests_{0}, retries_{0}, bytes_{0};
};

} // namespace tessera
