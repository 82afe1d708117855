#pragma once

#include <grpcpp/channel.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/sdk/channel.h"
#include "client/sdk/pose/motion_signals.h"
#include "client/sdk/pose/pose_estimate.h"
#include "client/sdk/requests.h"
#include "client/sdk/session_options.h"
#include "client/sdk/session_stats.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

class SessionEngine;

/// One vehicle's localization session: scans in, exactly one answer to each out, in the same order.
/// Position fixes may be sent among the scans, and are answered in their place.
///
/// When the connection breaks or the server drains, the session reconnects by itself and continues.
/// Unanswered scans are sent again, and none is localized twice. If the server has not kept the
/// session, a new one begins with the last pose as prior, and `on_event` reports it. It ends when
/// the server ends it, or refuses it, or cannot be reached for too long.
///
/// All members may be called from any thread at any time; scans from several threads are sent in
/// the order in which `Send` takes them. None but `Open`, a blocking `Send` or `SendFix`, `Next`
/// and the destructor waits for the network.
class Session {
 public:
  /// Opens a session and waits until the server has said that it is open. The server's own refusal
  /// (InvalidArgument, NotFound, ...), Unavailable when it cannot be reached, or DeadlineExceeded
  /// after `open_timeout`; with a `record_file` also what is wrong with that.
  static absl::StatusOr<std::unique_ptr<Session>> Open(
      const std::shared_ptr<grpc::Channel>& channel, v1::OpenSession open,
      const SessionOptions& options = {});

  /// The same at the server that `server` names, over a channel of `MakeChannel`.
  static absl::StatusOr<std::unique_ptr<Session>> Connect(const ChannelOptions& server,
                                                          v1::OpenSession open,
                                                          const SessionOptions& options = {});

  /// Ends the session at once if it has not ended, and waits until its stream is gone.
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// What the server said on opening, the first time.
  const v1::SessionOpened& opened() const;

  /// Queues `scan` for sending. ResourceExhausted when the queue is full (`FullQueue::kReject`),
  /// FailedPrecondition after `CloseSending`, Unavailable once the session has ended; `Next` and
  /// `EndStatus` then say why.
  absl::Status Send(v1::Scan scan);

  /// Queues what a radar measured at a stamp of the vehicle's clock; numbered after the scans
  /// before it. The rest is as of `Send`.
  absl::Status SendTargets(const std::string& radar_id, std::int64_t stamp_ns,
                           std::span<const Target> targets);

  /// Queues a position fix behind the scans that were sent before it. ResourceExhausted when
  /// `max_unanswered_fix_count` of them have no answer yet (`FullQueue::kReject`), Unimplemented
  /// when the server is too old to take any, else as `Send`. A fix whose answer has not come when
  /// the connection breaks is not sent again, since it may have been used; `stats` counts those.
  absl::Status SendFix(v1::PositionFix fix);

  /// Says that no more scans and fixes will come. The queued ones are still sent and answered, then
  /// the session ends.
  void CloseSending();

  /// The next answer, a `result` or `rejected`, or a `position_fix_answer` where fixes were sent,
  /// waiting for it; nothing once the session has ended and every answer has been given out.
  std::optional<v1::LocalizeResponse> Next();

  /// Takes what wheels and gyroscope say, each at its own rate, for `PoseAt`. Scans that are sent
  /// without an ego-velocity get it from here, where both are known at their stamps. The ticks
  /// since the scan before go along, so that the server knows how the vehicle moved in between.
  /// InvalidArgument names the field and the value.
  absl::Status AddMotion(const MotionTick& tick);

  /// Takes the vehicle's velocity as a whole, for `PoseAt`; nothing is sent. That of scans is taken
  /// already. InvalidArgument names the field and the value.
  absl::Status AddEgoVelocity(std::int64_t stamp_ns, const v1::EgoVelocity& velocity);

  /// Where the vehicle was at a stamp of its clock, between answers or shortly after the newest, by
  /// its own motion. Takes no lock. FailedPrecondition while no answer has a pose; OutOfRange later
  /// than `SessionOptions::pose.max_ahead` after the newest answer, and before what is kept.
  absl::StatusOr<PoseEstimate> PoseAt(std::int64_t stamp_ns) const;

  /// The same for controllers: where an answer makes `PoseAt` jump, this follows at a bounded rate
  /// (`SessionOptions::pose.bleed_mps`), with a covariance that includes the distance that is left.
  absl::StatusOr<PoseEstimate> SmoothPoseAt(std::int64_t stamp_ns) const;

  /// Ends the session without waiting for what is under way.
  void Cancel();

  /// Why the session ended, after `Next` gave nothing: OK when all scans sent were answered.
  /// FailedPrecondition while it has not ended.
  absl::Status EndStatus() const;

  /// The status of the recording; to be called after `Next` returned nothing.
  absl::Status record_status() const;

  /// How often the connection broke, how the session was resumed, and what was lost.
  SessionStats stats() const;

 private:
  explicit Session(std::unique_ptr<SessionEngine> engine);

  std::unique_ptr<SessionEngine> engine_;
};

}  // namespace dcloc::client
