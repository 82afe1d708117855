#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "dcloc/v1/pass_service.grpc.pb.h"

namespace dcloc::client {

/// The passes that a server keeps, and the consents to it. Calls block, each for `timeout` at most;
/// errors are the server's own, or Unavailable and DeadlineExceeded when it cannot be reached.
/// Thread-safe.
class PassClient {
 public:
  explicit PassClient(const std::shared_ptr<grpc::Channel>& channel,
                      std::chrono::milliseconds timeout = std::chrono::seconds(15));

  /// Gives how many passes were removed with a consent that is withdrawn.
  absl::StatusOr<int> SetConsent(const v1::PassConsent& consent, v1::PassConsentState state);

  /// Those that are given.
  absl::StatusOr<std::vector<v1::PassConsent>> ListConsents();

  /// Over a map, newest first.
  absl::StatusOr<std::vector<v1::Pass>> List(const std::string& map_name);

 private:
  std::unique_ptr<v1::PassService::Stub> stub_;
  std::chrono::milliseconds timeout_;
};

}  // namespace dcloc::client
