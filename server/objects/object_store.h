#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/files.h"
#include "server/objects/circuit_breaker.h"
#include "server/objects/object_options.h"
#include "server/objects/s3_client.h"

namespace dcloc::server {

/// What was asked of an object store so far.
struct ObjectCounts {
  std::atomic<std::int64_t> answered = 0;  ///< requests, after how many attempts so ever
  std::atomic<std::int64_t> failed = 0;    ///< requests that had no good answer in the end
  std::atomic<std::int64_t> repeated = 0;  ///< attempts beyond a request's first one
  std::atomic<std::int64_t> read_bytes = 0;
  std::atomic<std::int64_t> written_bytes = 0;
};

/// The objects below a prefix of a bucket, in a service that speaks S3. Keys are relative to the
/// prefix, and consist of letters, digits, ".", "_", "-" and "/". Thread-safe.
///
/// Calls wait for the network: for each request at most three times `ObjectOptions::timeout`, and
/// the time of its body at `min_rate_bytes_per_s`. What may pass (no connection, a cut or slow
/// body, 5xx, 429) is tried again within bounds. Then, and when the service refuses this server,
/// the error is one of `ObjectStoreError`. While the service is known to be away, calls fail at
/// once
/// (`CircuitBreaker`).
class ObjectStore {
 public:
  /// Checks the options and the credentials, and sends nothing. InvalidArgument names the setting.
  /// The credentials are read anew for each request, so that they can be changed.
  static absl::StatusOr<std::unique_ptr<ObjectStore>> Open(const ObjectOptions& options);

  /// Stores bytes of a file, which have this hash, in place of what was there. The service is asked
  /// to compare the hash; whether it did is not known.
  absl::Status Put(absl::string_view key, const FileDescriptor& file, std::int64_t size_bytes,
                   absl::string_view sha256);
  absl::Status PutText(absl::string_view key, absl::string_view text);

  /// Fills `bytes` from the object's `offset_bytes` on. NotFound; DataLoss: it ends before.
  absl::Status Read(absl::string_view key, std::int64_t offset_bytes, std::span<std::byte> bytes);

  /// A small object; NotFound.
  absl::StatusOr<std::string> ReadText(absl::string_view key);

  /// An object's size in bytes; NotFound.
  absl::StatusOr<std::int64_t> SizeOf(absl::string_view key);

  /// Copies an object within the service. NotFound.
  absl::Status Copy(absl::string_view from, absl::string_view to);

  /// Removes an object if it is there.
  absl::Status Remove(absl::string_view key);

  /// The objects whose keys begin with `prefix`, without it, and their sizes in bytes.
  absl::StatusOr<std::map<std::string, std::int64_t>> List(absl::string_view prefix);

  /// Whether it did not answer last time.
  bool away() const { return breaker_.away(); }

  const ObjectOptions& options() const { return options_; }
  const ObjectCounts& counts() const { return counts_; }

 private:
  ObjectStore(const ObjectOptions& options, ObjectLocation location);

  std::string UrlOf(absl::string_view key) const;
  absl::Status PutBody(absl::string_view key, S3Body body, absl::string_view sha256);

  /// Sends a request until there is an answer that no further attempt would better: a good one, or
  /// NotFound.
  absl::StatusOr<S3Answer> Ask(S3Request request, absl::string_view body_sha256);
  absl::StatusOr<S3Answer> AskOnce(const S3Request& request, absl::string_view body_sha256);

  const ObjectOptions options_;
  const ObjectLocation location_;
  S3Client client_;
  CircuitBreaker breaker_;
  ObjectCounts counts_;
};

}  // namespace dcloc::server
