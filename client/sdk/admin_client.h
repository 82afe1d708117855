#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dcloc/v1/admin_service.grpc.pb.h"

namespace dcloc::client {

/// The operators' RPCs of a server. Calls block, each for `timeout` at most; errors are the
/// server's own, or Unavailable and DeadlineExceeded when it cannot be reached. Thread-safe.
class AdminClient {
 public:
  explicit AdminClient(const std::shared_ptr<grpc::Channel>& channel,
                       std::chrono::milliseconds timeout = std::chrono::seconds(15));

  /// The servers that share a catalogue with this one, itself among them.
  absl::StatusOr<std::vector<v1::Replica>> ListReplicas();

  /// Of the server itself, or of another one with the address `replica`.
  absl::StatusOr<v1::GetServerStateResponse> ServerState(const std::string& replica = "");

  /// Returns how many sessions were told to move.
  absl::StatusOr<int> Drain(const std::string& replica = "");

  /// All open sessions of all replicas, by ascending id. Where some did not answer their sessions
  /// are missing, and `unanswered`, if it is not null, has them.
  absl::StatusOr<std::vector<v1::Session>> ListSessions(
      std::vector<v1::ReplicaFault>* unanswered = nullptr);

  absl::StatusOr<v1::Session> GetSession(const std::string& session_id);

  /// The session's client is given `reason`.
  absl::Status EndSession(const std::string& session_id, const std::string& reason);

  /// Tells the session where its vehicle was at its last scan, and returns what became of it.
  absl::StatusOr<v1::PositionFixAnswer> ProposePose(const std::string& session_id,
                                                    const v1::PoseWithCovariance& pose);

  /// What the tenant's callers changed lately, newest first.
  absl::StatusOr<std::vector<v1::Operation>> ListOperations();

  /// Who is let in, by ascending id, those that were revoked among them.
  absl::StatusOr<std::vector<v1::Identity>> ListIdentities();

  absl::Status RevokeIdentity(std::int64_t id);

  /// Records the vehicle's next session: passes on its header, its scans and its position fixes
  /// until it ends.
  /// `on_ready` is called once the server waits for the session. OK when the session has ended or
  /// `stop` was requested.
  absl::Status RecordSession(
      const std::string& vehicle_id, const std::stop_token& stop,
      const std::function<void()>& on_ready,
      const std::function<void(const v1::RecordSessionResponse&)>& on_message);

  /// Hands over the session's answers as they come, those to position fixes too, without a time
  /// limit. OK when the session has ended or `stop` was requested.
  absl::Status WatchSession(const std::string& session_id, const std::stop_token& stop,
                            const std::function<void(const v1::WatchSessionResponse&)>& on_answer);

 private:
  std::unique_ptr<v1::AdminService::Stub> stub_;
  std::chrono::milliseconds timeout_;
};

}  // namespace dcloc::client
