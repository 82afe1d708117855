#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "client/sdk/pose/pose_estimate.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

/// What `Session::Send` and `SendFix` do when the queue is full.
enum class FullQueue {
  kBlock,   ///< waits: for a replay, where every scan counts
  kReject,  ///< refuses the scan at once: for a vehicle, where a late scan is worth little
};

/// What becomes of answers that `Session::Next` does not take, once they are as many as are kept.
enum class UnreadAnswers {
  kHoldBack,      ///< no more are read, the server stops reading scans, and so the queue fills
  kForgetOldest,  ///< for who only asks for poses, and never calls `Next`
};

/// How a broken connection is mended. Waits grow from the first to the last backoff, with jitter.
struct ReconnectOptions {
  std::chrono::milliseconds initial_backoff{100};
  std::chrono::milliseconds max_backoff = std::chrono::seconds(3);
  /// Without any progress for so long, the session ends.
  std::chrono::milliseconds give_up_after = std::chrono::minutes(2);
};

/// What happens to a session's connection.
struct SessionEvent {
  enum class Kind {
    kDisconnected,  ///< the stream ended with `status`; another one will be tried
    kMoving,        ///< the server is leaving, `status` says why; the session looks for another one
    /// The session goes on as if nothing had happened; at another server, where `opened.ticket_use`
    /// is TICKET_USE_ACCEPTED.
    kResumed,
    /// A new session was opened with the last pose as prior, since `status` says why the one before
    /// could not be resumed. Poses may jump, and `opened` may name another map version.
    kRestarted,
  };
  Kind kind = Kind::kDisconnected;
  absl::Status status;
  v1::SessionOpened opened;  ///< of kResumed and kRestarted
};

struct SessionOptions {
  std::size_t max_queued_scan_count = 16;  ///< accepted by Send, not yet taken by the transport
  FullQueue when_full = FullQueue::kReject;
  /// Answers kept for `Next`, so that nothing grows without bound.
  std::size_t max_unread_answer_count = 1024;
  UnreadAnswers unread_answers = UnreadAnswers::kHoldBack;
  std::chrono::milliseconds open_timeout = std::chrono::seconds(10);
  /// Position fixes accepted by SendFix and not yet answered. They hold no scan back.
  std::size_t max_unanswered_fix_count = 16;
  /// Scans on their way: sent and kept, since they may have to be sent again, until they are
  /// answered. Never more than the server keeps answers for.
  std::size_t max_unanswered_scan_count = 64;
  /// None: the session ends when its connection breaks.
  std::optional<ReconnectOptions> reconnect = ReconnectOptions{};
  /// Not empty: the session is recorded there (see recording.h) as its answers are taken with
  /// `Next`, until it ends or begins anew.
  std::string record_file;
  /// How `PoseAt` and `SmoothPoseAt` tell poses.
  PoseOptions pose;
  /// Called on a thread of the SDK, one event at a time; must not call the session's destructor.
  std::function<void(const SessionEvent&)> on_event;
};

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const SessionOptions& options);

}  // namespace dcloc::client
