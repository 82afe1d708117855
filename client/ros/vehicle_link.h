#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/sdk/session.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::node {

/// How the link to the server is.
struct LinkStatus {
  enum class Phase {
    kWaiting,       ///< for the vehicle's radars
    kConnecting,    ///< no session yet, or none any more: another one is tried
    kOpen,          ///< there is a session
    kReconnecting,  ///< its connection is broken, and is being mended
  };
  Phase phase = Phase::kWaiting;
  std::string text;  ///< what was wrong last; empty while nothing was
  std::string session_id;
  std::int64_t map_version = 0;
  std::int64_t session_count = 0;  ///< opened so far
  std::int64_t disconnect_count = 0;
};

/// A session with the server that is opened again whenever it ends. Nothing here waits for the
/// network but the destructor. All members may be called from any thread.
class VehicleLink {
 public:
  using OnAnswer = std::function<void(const v1::LocalizeResponse&)>;

  /// `on_answer` is called on a thread of the link's own. A session that could not be opened, or
  /// has ended, is followed by another one after `retry_after`.
  VehicleLink(std::shared_ptr<grpc::Channel> channel, client::SessionOptions options,
              std::chrono::milliseconds retry_after, OnAnswer on_answer);
  ~VehicleLink();
  VehicleLink(const VehicleLink&) = delete;
  VehicleLink& operator=(const VehicleLink&) = delete;

  /// Begins to open sessions by `open`. What was given before is replaced, for the next session.
  void Open(v1::OpenSession open);

  /// The first session begins near this pose; one that is there is told by a fix in place of this.
  void SetInitialPose(const v1::PoseWithCovariance& pose);

  bool is_open() const { return session() != nullptr; }

  /// As those of Session; Unavailable while there is none.
  absl::Status Send(v1::Scan scan);
  absl::Status SendFix(v1::PositionFix fix);
  void AddVelocity(std::int64_t stamp_ns, const v1::EgoVelocity& velocity);
  absl::StatusOr<client::PoseEstimate> SmoothPoseAt(std::int64_t stamp_ns) const;

  LinkStatus status() const;

 private:
  std::shared_ptr<client::Session> session() const;
  void Run(const std::stop_token& stop);
  void RunSession(const v1::OpenSession& open, const std::stop_token& stop);
  void OnEvent(const client::SessionEvent& event);

  const std::shared_ptr<grpc::Channel> channel_;
  client::SessionOptions options_;
  const std::chrono::milliseconds retry_after_;
  const OnAnswer on_answer_;

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<v1::OpenSession> open_;
  std::shared_ptr<client::Session> session_;
  LinkStatus status_;

  std::jthread thread_;  ///< last: it uses the others
};

}  // namespace dcloc::node
