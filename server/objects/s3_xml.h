#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// A page of a list of objects, as S3 answers ListObjectsV2.
struct S3Page {
  std::vector<std::pair<std::string, std::int64_t>> objects;  ///< keys and sizes in bytes, by key
  bool is_last = true;
};

/// Reads one. DataLoss when it is none or was cut off.
absl::StatusOr<S3Page> ParseS3Page(absl::string_view xml);

/// The code of an error that S3 answered with, such as "NoSuchBucket"; empty when there is none.
std::string S3ErrorCode(absl::string_view xml);

}  // namespace dcloc::server
