#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/object_pool.h"
#include "server/objects/object_credentials.h"

namespace dcloc::server {

/// The bytes of a request, of which `read` gives those from `offset` on, as many as fit; 0 when it
/// cannot.
struct S3Body {
  std::int64_t size_bytes = 0;
  std::function<std::size_t(std::int64_t offset, std::span<std::byte> buffer)> read;
};

struct S3Request {
  std::string method;                     ///< GET, HEAD, PUT or DELETE
  std::string url;                        ///< with its query sorted and encoded, as it is signed
  std::vector<std::string> headers = {};  ///< "Name: value"; signed
  std::string range = {};                 ///< "FIRST-LAST", or empty
  S3Body body = {};                       ///< of a PUT
  /// Takes the body of a good answer, which must not be longer. Where it is empty, the body goes to
  /// `S3Answer::text`.
  std::span<std::byte> sink = {};
  std::chrono::milliseconds timeout{};  ///< of all of it
};

struct S3Answer {
  int status = 0;                ///< of HTTP
  std::int64_t size_bytes = -1;  ///< that its header announces; -1: none
  std::size_t sink_bytes = 0;    ///< that went to the sink
  std::string text;              ///< the body, of a failed request too; at most `kMaxText_bytes`
  static constexpr std::size_t kMaxText_bytes = std::size_t{4} << 20;
};

/// How requests of one service are sent.
struct S3Options {
  std::string region;   ///< in the signature
  std::string ca_file;  ///< PEM; empty: the system's
  std::chrono::milliseconds connect_timeout{};
  std::chrono::milliseconds pause_timeout{};  ///< of a body; to the second above
  double min_rate_bytes_per_s = 1.0;          ///< over `pause_timeout`
};

/// Sends requests to an S3 service, signed with AWS's signature version 4. Connections are kept and
/// used again. Follows no redirection, uses no proxy, and reads no file of settings. Thread-safe.
class S3Client {
 public:
  explicit S3Client(S3Options options);
  ~S3Client();
  S3Client(const S3Client&) = delete;
  S3Client& operator=(const S3Client&) = delete;

  /// The answer, whatever its status. Errors say why there is none: Unavailable, which may pass;
  /// FailedPrecondition, which will not, such as a certificate that is not trusted. `body_sha256`
  /// is that of the request's body, and signed.
  absl::StatusOr<S3Answer> Send(const S3Request& request, absl::string_view body_sha256,
                                const ObjectCredentials& credentials);

 private:
  struct Handle;

  const S3Options options_;
  ObjectPool<Handle> handles_;
};

}  // namespace dcloc::server
