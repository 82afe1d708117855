#pragma once

#include <filesystem>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dcloc::server {

/// Whether the store in `folder` has ever had an identity, as its catalogue notes. The identities
/// themselves cannot say so once they are lost, and without any everyone is an admin. False when
/// there is no catalogue.
absl::StatusOr<bool> HasIdentityMark(const std::filesystem::path& folder);

/// Notes it, for good. Does nothing when there is no catalogue yet: the next start notes it.
absl::Status SetIdentityMark(const std::filesystem::path& folder);

/// Of a store that has no identities. FailedPrecondition, with what to do, when it had some.
absl::Status CheckNoIdentityIsLost(const std::filesystem::path& folder);

}  // namespace dcloc::server
