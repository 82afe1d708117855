#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace dcloc::server::convert {

/// How many entries a page has: 100 for 0. InvalidArgument outside of [0, 1000].
absl::StatusOr<int> PageSizeFromProto(std::int32_t page_size);

/// A page token that is a number; `first` for the first page. InvalidArgument when it is none.
absl::StatusOr<std::int64_t> NumberFromPageToken(const std::string& page_token, std::int64_t first);

/// OK for a page token that can be the name of an entry.
absl::Status CheckPageToken(const std::string& page_token);

}  // namespace dcloc::server::convert
