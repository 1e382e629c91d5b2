// bricking/remote/http_client.cpp: see http_client.h. By libcurl.
#include "bricking/remote/http_client.h"

#include "bricking/store/remote_files.h" // OutOfReach
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <charconv>
#include <condition_variable>
#include <cstdlib>
#include <curl/curl.h>
#include <exception>
#include <filesystem>
#include <string_view>
#include <thread>
#include <utility>

namespace tessera {
namespace {

constexpr long kConnectSeconds = 10;
constexpr long kSlowBytesASecond = 1024, kSlowSeconds = 20; // slower than that for so long: given up
constexpr long kMostSecondsEach = 300;                      // of a request that goes on, over a slow line
constexpr long kMostRedirects = 5;
constexpr long kOk = 200, kPartial = 206, kNotModified = 304, kForbidden = 403, kNotFound = 404, kGone = 410,
               kNoSuchRange = 416, kTooMany = 429, kServerError = 500;
constexpr int kMostRetryAfterSeconds = 30;

std::string lower(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(),
                   [](unsigned char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c); });
    return out;
}

std::optional<std::uint64_t> numberIn(std::string_view text) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// The file of certificates that servers are checked by: SSL_CERT_FILE, else where Debian, Fedora or openSUSE
/// keep it, because libcurl may be of another system; empty: libcurl's own.
std::string certificateFile() {
    if (const char* said = std::getenv("SSL_CERT_FILE"); said && *said)
        return said;
    std::error_code ignored;
    for (const char* file :
         {"/etc/ssl/certs/ca-certificates.crt", "/etc/pki/tls/certs/ca-bundle.crt", "/etc/ssl/ca-bundle.pem"})
        if (std::filesystem::exists(file, ignored))
            return file;
    return {};
}

} // namespace

/// One request and its answer.
struct HttpClient::Try {
    long status = 0;
    CURLcode result = CURLE_OK;
    std::string etag, lastModified, contentRange, contentLength, retryAfter;
    std::vector<std::byte> body;
    std::size_t most = 0; // bytes of body that are wanted
    bool isLonger = false;
    const HttpClient* client = nullptr;
    std::exception_ptr stopped; // by Ctrl-C or HttpClient::stop()

    bool mayWorkLater() const {
        if (result != CURLE_OK)
            return result != CURLE_PEER_FAILED_VERIFICATION && result != CURLE_SSL_CACERT_BADFILE &&
                   result != CURLE_URL_MALFORMAT && result != CURLE_UNSUPPORTED_PROTOCOL &&
                   result != CURLE_TOO_MANY_REDIRECTS && result != CURLE_LOGIN_DENIED;
        return status == kTooMany || status >= kServerError;
    }
    std::string why() const {
        return result != CURLE_OK ? curl_easy_strerror(result) : "the answer " + std::to_string(status);
    }
    static std::size_t onBody(const char* data, std::size_t, std::size_t count, void* self);
    static std::size_t onHeader(const char* data, std::size_t, std::size_t count, void* self);
    static int onProgress(void* self, curl_off_t, curl_off_t, curl_off_t, curl_off_t);
};

std::size_t HttpClient::Try::onBody(const char* data, std::size_t, std::size_t count, void* self) {
    auto& answer = *static_cast<Try*>(self);
    const std::size_t taken = std::min(count, answer.most - answer.body.size());
    const auto* const bytes = reinterpret_cast<const std::byte*>(data);
    answer.body.insert(answer.body.end(), bytes, bytes + taken);
    answer.isLonger = answer.isLonger || taken < count;
    return answer.isLonger ? 0 : count; // 0 ends the transfer: a server without ranges sends all
}

std::size_t HttpClient::Try::onHeader(const char* data, std::size_t, std::size_t count, void* self) {
    auto& answer = *static_cast<Try*>(self);
    const std::string_view line(data, count);
    if (line.starts_with("HTTP/")) { // of another answer, after a redirect
        for (std::string* text : {&answer.etag, &answer.lastModified, &answer.contentRange,
                                  &answer.contentLength, &answer.retryAfter})
            text->clear();
        answer.body.clear();
    }
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos)
        return count;
    const std::string name = lower(line.substr(0, colon));
    std::string_view value = line.substr(colon + 1);
    while (!value.empty() && (value.front() == ' ' || value.front() == '\t'))
        value.remove_prefix(1);
    while (!value.empty() && static_cast<unsigned char>(value.back()) <= ' ')
        value.remove_suffix(1);
    for (const auto& [known, text] : {std::pair("etag", &answer.etag),
                                      {"last-modified", &answer.lastModified},
                                      {"content-range", &answer.contentRange},
                                      {"content-length", &answer.contentLength},
                                      {"retry-after", &answer.retryAfter}})
        if (name == known)
            *text = value;
    return count;
}

int HttpClient::Try::onProgress(void* self, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
    Try& answer = *static_cast<Try*>(self);
    try {
        answer.client->checkStopped();
        return 0;
    } catch (...) {
        answer.stopped = std::current_exception();
        return 1;
    }
}

/// Connections of requests that ended, for the next ones.
struct HttpClient::Pool {
    std::mutex mutex;
    std::condition_variable released;
    std::vector<CURL*> idle;
    int inUse = 0;
};

class HttpClient::Handle {
  public:
    explicit Handle(Pool& pool) : pool_(pool) {
        std::unique_lock lock(pool_.mutex);
        pool_.released.wait(lock, [&] { return pool_.inUse < kMostAtOnce; });
        ++pool_.inUse;
        if (!pool_.idle.empty()) {
            curl_ = pool_.idle.back();
            pool_.idle.pop_back();
        } else {
            curl_ = curl_easy_init();
        }
    }
    ~Handle() {
        const std::lock_guard lock(pool_.mutex);
        if (curl_)
            pool_.idle.push_back(curl_);
        --pool_.inUse;
        pool_.released.notify_one();
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    CURL* get() const { return curl_; }

  private:
    Pool& pool_;
    CURL* curl_ = nullptr;
};

HttpClient::HttpClient(std::chrono::milliseconds firstWait)
    : firstWait_(firstWait), pool_(std::make_unique<Pool>()) {
    static const CURLcode once = curl_global_init(CURL_GLOBAL_DEFAULT);
    if (once != CURLE_OK)
        throw Error(std::string("libcurl could not begin: ") + curl_easy_strerror(once));
}

HttpClient::~HttpClient() {
    for (CURL* const curl : pool_->idle)
        curl_easy_cleanup(curl);
}

HttpClient::Try HttpClient::attempt(const std::string& address, std::uint64_t offset, std::size_t count,
                                    const HttpVersion& known) {
    const Handle handle(*pool_);
    CURL* const curl = handle.get();
    if (!curl)
        throw Error("libcurl could not begin");
    Try answer;
    answer.most = count;
    answer.client = this;
    const std::string range = std::to_string(offset) + "-" + std::to_string(offset + count - 1);
    curl_easy_reset(curl); // connections stay
    curl_easy_setopt(curl, CURLOPT_URL, address.c_str());
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_REDIR_PROTOCOLS_STR,
                     address.starts_with("https") ? "https" : "http,https");
    curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 1L);
    curl_easy_setopt(curl, CURLOPT_MAXREDIRS, kMostRedirects);
    curl_easy_setopt(curl, CURLOPT_RANGE, range.c_str());
    curl_easy_setopt(curl, CURLOPT_USERAGENT, "tessera");
    if (const std::string file = certificateFile(); !file.empty())
        curl_easy_setopt(curl, CURLOPT_CAINFO, file.c_str());
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, kConnectSeconds);
    curl_easy_setopt(curl, CURLOPT_TIMEOUT, kMostSecondsEach);
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, kSlowBytesASecond);
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, kSlowSeconds);
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, Try::onBody);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, &answer);
    curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, Try::onHeader);
    curl_easy_setopt(curl, CURLOPT_HEADERDATA, &answer);
    curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L);
    curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, Try::onProgress);
    curl_easy_setopt(curl, CURLOPT_XFERINFODATA, &answer);
    const std::string condition =
        known.tag.empty() ? "If-Modified-Since: " + known.date : "If-None-Match: " + known.tag;
    curl_slist* const headers = known.isSaid() ? curl_slist_append(nullptr, condition.c_str()) : nullptr;
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers);
    answer.result = curl_easy_perform(curl);
    curl_slist_free_all(headers);
    curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &answer.status);
    ++requests_;
    bytes_ += answer.body.size();
    if (answer.stopped)
        std::rethrow_exception(answer.stopped);
    if (answer.result == CURLE_WRITE_ERROR && answer.isLonger)
        answer.result = CURLE_OK; // ended by onBody()
    return answer;
}

void HttpClient::wait(std::chrono::milliseconds time) const {
    const auto end = std::chrono::steady_clock::now() + time;
    constexpr std::chrono::milliseconds kStep{20};
    while (std::chrono::steady_clock::now() < end) {
        checkStopped();
        std::this_thread::sleep_for(kStep);
    }
}

void HttpClient::checkStopped() const {
    checkInterrupted();
    if (isStopped_)
        throw Cancelled();
}

namespace {

/// "bytes 0-99/1234"; of "bytes */1234" the total alone.
struct Range {
    std::uint64_t first = 0, last = 0, total = 0;
};
std::optional<Range> rangeOf(std::string_view text) {
    const std::size_t slash = text.rfind('/');
    if (!text.starts_with("bytes ") || slash == std::string_view::npos)
        return std::nullopt;
    const auto total = numberIn(text.substr(slash + 1));
    const std::string_view part = text.substr(6, slash - 6);
    const std::size_t dash = std::min(part.find('-'), part.size());
    const std::optional<std::uint64_t> zero(0);
    const auto first = part == "*" ? zero : numberIn(part.substr(0, dash));
    const auto last = part == "*" ? zero : numberIn(part.substr(std::min(dash + 1, part.size())));
    return total && first && last ? std::optional(Range{*first, *last, *total}) : std::nullopt;
}

} // namespace

std::optional<HttpPart> HttpClient::get(const std::string& address, const std::string& shown,
                                        std::uint64_t offset, std::size_t count, const HttpVersion& known) {
    using Clock = std::chrono::steady_clock;
    TESSERA_CHECK(count > 0);
    const Clock::time_point end = Clock::now() + kMostSeconds;
    const auto left = [&] {
        return std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    };
    bool isAnew = false; // whatever is known
    {
        const std::lock_guard lock(mutex_);
        if (std::chrono::steady_clock::now() < silentUntil_)
            throw OutOfReach(shown, "a server that answers", why_ + " a moment ago");
    }
    std::string why;
    bool isSilent = false; // no answer at all
    int number = 0;
    for (; number < kTries && left().count() > 0; ++number) {
        if (number > 0) {
            ++retries_;
            wait(std::min(firstWait_ * (1 << (number - 1)), left()));
        }
        checkStopped();
        Try answer = attempt(address, offset, count, isAnew ? HttpVersion{} : known);
        if (answer.status == kNotFound || answer.status == kGone)
            return std::nullopt;
        if (answer.result != CURLE_OK || answer.status == kTooMany || answer.status >= kServerError) {
            why = answer.why();
            isSilent = answer.result != CURLE_OK;
            if (!answer.mayWorkLater())
                throw OutOfReach(shown, "a server that can be reached and trusted", printable(why));
            if (const auto seconds = numberIn(answer.retryAfter); seconds && number + 1 < kTries)
                wait(std::min<std::chrono::milliseconds>(
                    std::chrono::seconds(std::min<std::uint64_t>(*seconds, kMostRetryAfterSeconds)), left()));
            continue;
        }
        HttpPart part;
        part.isForbidden = answer.status == kForbidden;
        if (part.isForbidden)
            return part;
        part.version = {answer.etag, answer.lastModified};
        if (answer.status == kNotModified && known.isSaid() && !isAnew) {
            // Servers without tags say it of any file that is not newer.
            isAnew = part.version.isSaid() && !part.version.isThatOf(known);
            if (isAnew)
                continue;
            part.isAsKnown = true;
            return part;
        }
        const std::optional<Range> range = rangeOf(answer.contentRange);
        if (answer.status == kNoSuchRange && range) { // nothing that far
            part.totalBytes = range->total;
            return part;
        }
        if (answer.status == kPartial && range && range->first == offset) {
            const std::uint64_t due =
                std::min<std::uint64_t>(count, range->total - std::min(range->total, offset));
            if (answer.body.size() < due && range->last - range->first + 1 == answer.body.size())
                throw badFile(shown, "a server that sends ranges of bytes", "one that sends shorter ones");
            if (answer.body.size() != due) {
                why = "an answer that was cut";
                continue;
            }
            part.totalBytes = range->total;
            part.bytes = std::move(answer.body);
            return part;
        }
        if (answer.status == kOk && offset == 0 && !answer.isLonger) { // the whole, shorter than the range
            const auto length = numberIn(answer.contentLength);
            if (length && *length != answer.body.size()) {
                why = "an answer that was cut";
                continue;
            }
            part.totalBytes = answer.body.size();
            part.bytes = std::move(answer.body);
            return part;
        }
        if (answer.status == kOk || answer.status == kPartial)
            throw badFile(shown, "a server that sends ranges of bytes", "one that sends others");
        throw badFile(shown, "a file that may be read", printable(answer.why()));
    }
    if (isSilent) {
        const std::lock_guard lock(mutex_);
        silentUntil_ = std::chrono::steady_clock::now() + kPause;
        why_ = printable(why);
    }
    throw OutOfReach(shown, "a server that answers",
                     printable(why) + ", after " + std::to_string(number) + " tries");
}

} // namespace tessera
