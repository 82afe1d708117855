#include "server/objects/s3_client.h"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "absl/strings/str_cat.h"
#include "server/base/within_memory.h"

namespace dcloc::server {
namespace {

struct FreeHeaders {
  void operator()(curl_slist* headers) const { curl_slist_free_all(headers); }
};
using Headers = std::unique_ptr<curl_slist, FreeHeaders>;

void Append(Headers& headers, const std::string& line) {
  curl_slist* const longer = curl_slist_append(headers.get(), line.c_str());
  if (longer == nullptr) return;
  headers.release();
  headers.reset(longer);
}

/// One exchange, as the library's callbacks see it.
struct Exchange {
  CURL* handle = nullptr;
  const S3Request* request = nullptr;
  std::int64_t sent_bytes = 0;
  S3Answer answer = {};
  bool too_long = false;

  long Status() const {
    long status = 0;
    curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
    return status;
  }

  bool Take(std::span<const char> piece) {
    const long status = Status();
    if (!request->sink.empty() && status >= 200 && status < 300) {
      too_long = piece.size() > request->sink.size() - answer.sink_bytes;
      if (too_long) return false;
      std::memcpy(request->sink.data() + answer.sink_bytes, piece.data(), piece.size());
      answer.sink_bytes += piece.size();
      return true;
    }
    too_long = piece.size() > S3Answer::kMaxText_bytes - answer.text.size();
    if (too_long) return false;
    answer.text.append(piece.data(), piece.size());
    return true;
  }
};

std::size_t WriteCallback(char* data, std::size_t, std::size_t size, void* user) {
  bool taken = false;  // nothing may be thrown through the library
  WithinMemory([&] { taken = static_cast<Exchange*>(user)->Take({data, size}); }).IgnoreError();
  return taken ? size : CURL_WRITEFUNC_ERROR;
}

std::size_t ReadCallback(char* buffer, std::size_t unit, std::size_t count, void* user) {
  auto* const exchange = static_cast<Exchange*>(user);
  const S3Body& body = exchange->request->body;
  const std::int64_t left = body.size_bytes - exchange->sent_bytes;
  const std::size_t wanted = std::min(unit * count, static_cast<std::size_t>(left));
  if (wanted == 0) return 0;
  const std::size_t size =
      body.read(exchange->sent_bytes, {reinterpret_cast<std::byte*>(buffer), wanted});
  if (size == 0) return CURL_READFUNC_ABORT;
  exchange->sent_bytes += static_cast<std::int64_t>(size);
  return size;
}

/// A kept connection may turn out to be closed: then the body is sent again from its beginning.
int SeekCallback(void* user, curl_off_t offset, int origin) {
  if (origin != SEEK_SET) return CURL_SEEKFUNC_FAIL;
  static_cast<Exchange*>(user)->sent_bytes = offset;
  return CURL_SEEKFUNC_OK;
}

/// What will not be better at the next attempt.
bool IsLasting(CURLcode code) {
  switch (code) {
    case CURLE_PEER_FAILED_VERIFICATION:
    case CURLE_SSL_CACERT_BADFILE:
    case CURLE_SSL_CERTPROBLEM:
    case CURLE_URL_MALFORMAT:
    case CURLE_UNSUPPORTED_PROTOCOL:
    case CURLE_NOT_BUILT_IN:
    case CURLE_UNKNOWN_OPTION:
    case CURLE_READ_ERROR:
    case CURLE_ABORTED_BY_CALLBACK:
      return true;
    default:
      return false;
  }
}

void SetMethod(CURL* handle, const S3Request& request) {
  if (request.method == "HEAD") {
    curl_easy_setopt(handle, CURLOPT_NOBODY, 1L);
  } else if (request.method == "PUT") {
    curl_easy_setopt(handle, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(handle, CURLOPT_INFILESIZE_LARGE, curl_off_t{request.body.size_bytes});
  } else if (request.method != "GET") {
    curl_easy_setopt(handle, CURLOPT_CUSTOMREQUEST, request.method.c_str());
  }
}

void SetCallbacks(CURL* handle, Exchange* exchange) {
  curl_easy_setopt(handle, CURLOPT_WRITEFUNCTION, &WriteCallback);
  curl_easy_setopt(handle, CURLOPT_WRITEDATA, exchange);
  curl_easy_setopt(handle, CURLOPT_READFUNCTION, &ReadCallback);
  curl_easy_setopt(handle, CURLOPT_READDATA, exchange);
  curl_easy_setopt(handle, CURLOPT_SEEKFUNCTION, &SeekCallback);
  curl_easy_setopt(handle, CURLOPT_SEEKDATA, exchange);
}

void SetOptions(CURL* handle, const S3Options& options) {
  constexpr long kBuffer_bytes = 256L << 10;
  constexpr long kExpectTimeout_ms = 500;
  constexpr long kNameKept_s = 1;  // a minute by default, in which a service that has moved is away
  curl_easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(handle, CURLOPT_PROXY, "");
  curl_easy_setopt(handle, CURLOPT_PATH_AS_IS, 1L);
  curl_easy_setopt(handle, CURLOPT_SSLVERSION, long{CURL_SSLVERSION_TLSv1_2});
  curl_easy_setopt(handle, CURLOPT_BUFFERSIZE, kBuffer_bytes);
  curl_easy_setopt(handle, CURLOPT_EXPECT_100_TIMEOUT_MS, kExpectTimeout_ms);
  curl_easy_setopt(handle, CURLOPT_DNS_CACHE_TIMEOUT, kNameKept_s);
  // Else a timeout waits until the system has given up a name: 10 s and more.
  curl_easy_setopt(handle, CURLOPT_QUICK_EXIT, 1L);
  curl_easy_setopt(handle, CURLOPT_CONNECTTIMEOUT_MS,
                   static_cast<long>(options.connect_timeout.count()));
  const auto pause = std::chrono::ceil<std::chrono::seconds>(options.pause_timeout);
  curl_easy_setopt(handle, CURLOPT_LOW_SPEED_TIME, static_cast<long>(pause.count()));
  curl_easy_setopt(handle, CURLOPT_LOW_SPEED_LIMIT,
                   std::max(1L, static_cast<long>(options.min_rate_bytes_per_s)));
  if (!options.ca_file.empty()) {
    curl_easy_setopt(handle, CURLOPT_CAINFO, options.ca_file.c_str());
  }
}

}  // namespace

/// Keeps its connections from one request to the next.
struct S3Client::Handle {
  Handle() {
    // Once in a process, before any other use.
    static const CURLcode global = curl_global_init(CURL_GLOBAL_DEFAULT);
    if (global == CURLE_OK) curl = curl_easy_init();
  }
  ~Handle() { curl_easy_cleanup(curl); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  CURL* curl = nullptr;
};

S3Client::S3Client(S3Options options) : options_(std::move(options)) {}

S3Client::~S3Client() = default;

absl::StatusOr<S3Answer> S3Client::Send(const S3Request& request, absl::string_view body_sha256,
                                        const ObjectCredentials& credentials) {
  const ObjectPool<Handle>::Lease lease = handles_.Acquire();
  CURL* const handle = (*lease).curl;
  if (handle == nullptr) return absl::UnavailableError("libcurl cannot start");
  curl_easy_reset(handle);
  Headers headers;
  Append(headers, absl::StrCat("x-amz-content-sha256: ", body_sha256));
  if (!credentials.session_token.empty()) {
    Append(headers, absl::StrCat("x-amz-security-token: ", credentials.session_token));
  }
  for (const std::string& line : request.headers) Append(headers, line);
  std::array<char, CURL_ERROR_SIZE> reason{};
  Exchange exchange{.handle = handle, .request = &request};
  SetOptions(handle, options_);
  SetCallbacks(handle, &exchange);
  SetMethod(handle, request);
  const std::string provider = absl::StrCat("aws:amz:", options_.region, ":s3");
  curl_easy_setopt(handle, CURLOPT_URL, request.url.c_str());
  curl_easy_setopt(handle, CURLOPT_AWS_SIGV4, provider.c_str());
  curl_easy_setopt(handle, CURLOPT_USERNAME, credentials.access_key_id.c_str());
  curl_easy_setopt(handle, CURLOPT_PASSWORD, credentials.secret_access_key.c_str());
  curl_easy_setopt(handle, CURLOPT_HTTPHEADER, headers.get());
  if (!request.range.empty()) curl_easy_setopt(handle, CURLOPT_RANGE, request.range.c_str());
  curl_easy_setopt(handle, CURLOPT_TIMEOUT_MS, static_cast<long>(request.timeout.count()));
  curl_easy_setopt(handle, CURLOPT_ERRORBUFFER, reason.data());
  const CURLcode code = curl_easy_perform(handle);
  curl_easy_setopt(handle, CURLOPT_ERRORBUFFER, nullptr);
  if (exchange.too_long)
    return absl::UnavailableError("the answer is longer than what was asked for");
  if (code != CURLE_OK) {
    const std::string text = absl::StrCat(curl_easy_strerror(code), ": ", reason.data());
    return IsLasting(code) ? absl::FailedPreconditionError(text) : absl::UnavailableError(text);
  }
  exchange.answer.status = static_cast<int>(exchange.Status());
  curl_off_t size_bytes = -1;
  curl_easy_getinfo(handle, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &size_bytes);
  exchange.answer.size_bytes = size_bytes;
  return std::move(exchange.answer);
}

}  // namespace dcloc::server
