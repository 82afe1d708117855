#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace dcloc::cli {

/// What a caller may do on a server, found out by calls that change nothing: each reads, or names
/// what there is not.
struct Rights {
  /// A permission and what its call came to; OK where it is granted.
  std::vector<std::pair<std::string, absl::Status>> calls;

  bool Grants(const std::string& permission) const;
  /// The status of the first call that was refused as of nobody known; else OK.
  absl::Status Unauthenticated() const;
  /// "vehicle", "viewer", "operator or admin", "none": the role that has just these.
  std::string Role() const;
};

/// Each call takes `timeout` at most.
Rights AskRights(const std::shared_ptr<grpc::Channel>& channel, std::chrono::milliseconds timeout);

}  // namespace dcloc::cli
