#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

/// What `Session::Send` does when the queue is full.
enum class FullQueue {
  kBlock,   ///< waits: for a replay, where every scan counts
  kReject,  ///< refuses the scan at once: for a vehicle, where a late scan is worth little
};

struct SessionOptions {
  std::size_t max_queued_scan_count = 16;  ///< accepted by Send, not yet taken by the transport
  FullQueue when_full = FullQueue::kReject;
  /// Answers kept for `Next`. When they are this many, no more are read, the server stops reading
  /// scans, and so the queue fills: nothing grows without bound.
  std::size_t max_unread_answer_count = 1024;
  std::chrono::milliseconds open_timeout = std::chrono::seconds(10);
};

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const SessionOptions& options);

/// One vehicle's localization session: scans in, an answer to each out, in the same order. A
/// session ends when the server ends it or the connection breaks; open another one then.
///
/// All members may be called from any thread at any time; scans from several threads are sent in
/// the order in which `Send` takes them. None but `Open`, a blocking `Send`, `Next` and the
/// destructor waits for the network.
class Session {
 public:
  /// Opens a session and waits until the server has said that it is open. The server's own refusal
  /// (InvalidArgument, NotFound, ...), Unavailable when it cannot be reached, or DeadlineExceeded
  /// after `open_timeout`.
  static absl::StatusOr<std::unique_ptr<Session>> Open(
      const std::shared_ptr<grpc::Channel>& channel, v1::OpenSession open,
      const SessionOptions& options = {});

  /// Ends the session at once if it has not ended, and waits until its stream is gone.
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// What the server said on opening.
  const v1::SessionOpened& opened() const;

  /// Queues `scan` for sending. ResourceExhausted when the queue is full (`FullQueue::kReject`),
  /// FailedPrecondition after `CloseSending`, Unavailable once the session has ended; `Next` and
  /// `EndStatus` then say why.
  absl::Status Send(v1::Scan scan);

  /// Says that no more scans will come. The queued ones are still sent and answered, then the
  /// session ends.
  void CloseSending();

  /// The next answer, a `result` or `rejected`, waiting for it; nothing once the session has ended
  /// and every answer has been given out.
  std::optional<v1::LocalizeResponse> Next();

  /// Ends the session without waiting for what is under way.
  void Cancel();

  /// Why the session ended, after `Next` gave nothing: OK when all scans sent were answered.
  /// FailedPrecondition while it has not ended.
  absl::Status EndStatus() const;

 private:
  class Stream;
  explicit Session(std::unique_ptr<Stream> stream);

  std::unique_ptr<Stream> stream_;
};

}  // namespace dcloc::client
