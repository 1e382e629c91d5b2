// tests/support/http_server.h: a server of files on this machine, for tests: ranges, versions, and all that
// goes wrong on the way.
#pragma once

#include <algorithm>
#include <arpa/inet.h>
#include <atomic>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <mutex>
#include <netinet/in.h>
#include <string>
#include <sys/socket.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace tessera::test {

/// One request as it came.
struct AskedOf {
    std::string target, range, condition, authorization; // target: "/a.zarr/0?x", range: "bytes=0-9"
};

class HttpServer {
  public:
    enum class Fault { none, unavailable, closed, cut };
    /// What happens to a request; of all, their number from 0.
    std::function<Fault(int number, const AskedOf& asked)> fault = [](int, const AskedOf&) {
        return Fault::none;
    };
    std::chrono::milliseconds delay{0};
    bool hasRanges = true, hasVersions = true;
    bool hasTags = true;                          // false: versions are dates
    bool isGenerous = false;                      // sends more than was asked for
    std::map<std::string, std::string> redirects; // from a target to an address
    std::map<std::string, int> statuses;          // of targets

    explicit HttpServer(std::filesystem::path folder) : folder_(std::move(folder)) {
        listening_ = ::socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in at{};
        at.sin_family = AF_INET;
        at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof at;
        if (::bind(listening_, reinterpret_cast<sockaddr*>(&at), sizeof at) != 0 ||
            ::listen(listening_, 64) != 0 ||
            ::getsockname(listening_, reinterpret_cast<sockaddr*>(&at), &size) != 0)
            throw std::runtime_error("no port for a test's server");
        port_ = ntohs(at.sin_port);
        accepting_ = std::jthread([this] { accept(); });
    }
    ~HttpServer() {
        ::shutdown(listening_, SHUT_RDWR);
        accepting_.join();
        ::close(listening_);
        {
            const std::lock_guard lock(mutex_);
            for (const int connection : open_)
                ::shutdown(connection, SHUT_RDWR);
        }
        serving_.clear(); // joins
    }

    std::string address(const std::string& name = "") const {
        return "http://127.0.0.1:" + std::to_string(port_) + "/" + name;
    }
    std::vector<AskedOf> asked() const {
        const std::lock_guard lock(mutex_);
        return asked_;
    }
    std::size_t bytesSent() const { return sent_; }

  private:
    void accept() {
        while (true) {
            const int connection = ::accept(listening_, nullptr, nullptr);
            if (connection < 0)
                return;
            const std::lock_guard lock(mutex_);
            open_.push_back(connection);
            serving_.emplace_back([this, connection] {
                serve(connection);
                const std::lock_guard ended(mutex_);
                std::erase(open_, connection);
                ::close(connection);
            });
        }
    }

    static std::string valueOf(const std::string& head, const std::string& name) {
        const std::size_t at = head.find("\r\n" + name + ": ");
        if (at == std::string::npos)
            return "";
        const std::size_t begin = at + 2 + name.size() + 2;
        return head.substr(begin, head.find("\r\n", begin) - begin);
    }

    bool send(int connection, const std::string& bytes) {
        for (std::size_t done = 0; done < bytes.size();) {
            const ssize_t put = ::send(connection, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
            if (put <= 0)
                return false;
            done += static_cast<std::size_t>(put);
        }
        return true;
    }

    static std::string decoded(const std::string& text) {
        std::string out;
        for (std::size_t i = 0; i < text.size(); ++i)
            if (text[i] == '%' && i + 2 < text.size()) {
                out += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
                i += 2;
            } else {
                out += text[i];
            }
        return out;
    }

    void serve(int connection) {
        std::string buffer;
        while (true) {
            std::size_t end = 0;
            while ((end = buffer.find("\r\n\r\n")) == std::string::npos) {
                char bytes[4096];
                const ssize_t got = ::recv(connection, bytes, sizeof bytes, 0);
                if (got <= 0)
                    return;
                buffer.append(bytes, static_cast<std::size_t>(got));
            }
            const std::string head = buffer.substr(0, end + 2);
            buffer.erase(0, end + 4);
            AskedOf one;
            one.target = head.substr(4, head.find(' ', 4) - 4);
            one.range = valueOf(head, "Range");
            one.condition = valueOf(head, "If-None-Match") + valueOf(head, "If-Modified-Since");
            one.authorization = valueOf(head, "Authorization");
            int number = 0;
            {
                const std::lock_guard lock(mutex_);
                number = static_cast<int>(asked_.size());
                asked_.push_back(one);
            }
            std::this_thread::sleep_for(delay);
            if (!answer(connection, one, fault(number, one)))
                return;
        }
    }

    static constexpr const char* kDate = "%a, %d %b %Y %H:%M:%S GMT";
    static std::time_t timeOf(const std::filesystem::path& path) {
        struct stat facts {};
        ::stat(path.c_str(), &facts);
        return facts.st_mtime;
    }
    static std::string dateOf(std::time_t time) {
        std::tm parts{};
        char text[64];
        ::gmtime_r(&time, &parts);
        return {text, std::strftime(text, sizeof text, kDate, &parts)};
    }
    static std::time_t timeOfDate(const std::string& text) {
        std::tm parts{};
        return ::strptime(text.c_str(), kDate, &parts) ? ::timegm(&parts) : 0;
    }

    /// False: the connection ends.
    bool answer(int connection, const AskedOf& one, Fault what) {
        const auto plain = [&](int status, const std::string& more = "") {
            return send(connection,
                        "HTTP/1.1 " + std::to_string(status) + " X\r\nContent-Length: 0\r\n" + more + "\r\n");
        };
        if (what == Fault::closed)
            return false;
        if (what == Fault::unavailable)
            return plain(503);
        if (const auto found = redirects.find(one.target); found != redirects.end())
            return plain(302, "Location: " + found->second + "\r\n");
        if (const auto found = statuses.find(one.target); found != statuses.end())
            return plain(found->second);
        const std::filesystem::path path = folder_ / decoded(one.target.substr(1, one.target.find('?') - 1));
        std::error_code none;
        if (!std::filesystem::is_regular_file(path, none))
            return plain(404);
        std::ifstream file(path, std::ios::binary);
        const std::string whole{std::istreambuf_iterator<char>(file), {}};
        const std::time_t time = timeOf(path);
        const std::string version = hasTags ? "\"" + std::to_string(std::hash<std::string>{}(whole)) + "\""
                                            : dateOf(time),
                          tag = (hasTags ? "ETag: " : "Last-Modified: ") + version + "\r\n";
        if (hasVersions && !one.condition.empty() &&
            (hasTags ? one.condition == version : time <= timeOfDate(one.condition)))
            return plain(304, tag);
        std::string body = whole, status = "200 OK", more = hasVersions ? tag : "";
        if (hasRanges && one.range.starts_with("bytes=")) {
            const std::size_t dash = one.range.find('-');
            const std::size_t first = std::stoull(one.range.substr(6, dash - 6)),
                              asked = std::stoull(one.range.substr(dash + 1)) + (isGenerous ? 1000 : 1),
                              last = std::min<std::size_t>(asked, whole.size());
            if (first >= whole.size())
                return plain(416, "Content-Range: bytes */" + std::to_string(whole.size()) + "\r\n");
            body = whole.substr(first, last - first);
            status = "206 Partial";
            more += "Content-Range: bytes " + std::to_string(first) + "-" + std::to_string(last - 1) + "/" +
                    std::to_string(whole.size()) + "\r\n";
        }
        std::string text = "HTTP/1.1 " + status + "\r\nContent-Length: " + std::to_string(body.size()) +
                           "\r\n" + more + "\r\n";
        if (what == Fault::cut) {
            send(connection, text + body.substr(0, body.size() / 2));
            return false;
        }
        sent_ += body.size();
        return send(connection, text + body);
    }

    std::filesystem::path folder_;
    int listening_ = -1, port_ = 0;
    mutable std::mutex mutex_;
    std::vector<AskedOf> asked_;
    std::vector<int> open_;
    std::atomic<std::size_t> sent_{0};
    std::vector<std::jthread> serving_;
    std::jthread accepting_;
};

} // namespace tessera::test
