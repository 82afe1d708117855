#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// How a bucket of an S3 service is reached, and how long that may take.
struct ObjectOptions {
  std::string location;  ///< "s3://BUCKET/PREFIX"; the prefix may be missing
  std::string endpoint;  ///< "https://HOST:PORT" of the service, without a path
  std::string region = "us-east-1";
  std::string credentials_file;  ///< empty: the environment (`ReadObjectCredentials`)
  std::string ca_file;           ///< PEM; empty: the authorities that the system trusts
  /// Of a request without its body, of a pause in its body, and of attempts at one: none begins
  /// later.
  std::chrono::milliseconds timeout{10'000};

  double min_rate_bytes_per_s = 250e3;            ///< of a body; a slower one is cut
  int max_attempt_count = 4;                      ///< of one request
  std::chrono::milliseconds first_pause{100};     ///< before the second attempt; then doubled
  std::chrono::milliseconds away_interval{1000};  ///< between looks whether it is back
  std::int64_t max_range_bytes = std::int64_t{8} << 20;  ///< that are asked for at once
};

/// The largest object that S3 takes in one request.
inline constexpr std::int64_t kMaxObject_bytes = std::int64_t{5} << 30;

/// Where in a service objects are.
struct ObjectLocation {
  std::string bucket;
  std::string prefix;  ///< empty, or ends with "/"
};

/// Reads "s3://BUCKET/PREFIX". InvalidArgument: a bucket that S3 would not take, or a prefix with
/// other characters than letters, digits, ".", "_", "-" and "/".
absl::StatusOr<ObjectLocation> ParseObjectLocation(absl::string_view location);

/// OK, or InvalidArgument naming the setting, its value and what it must be. Plain HTTP goes to
/// this host alone: maps are somebody's.
absl::Status Validate(const ObjectOptions& options);

}  // namespace dcloc::server
