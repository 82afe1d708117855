#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "client/sdk/backoff.h"
#include "client/sdk/connection.h"
#include "client/sdk/outbox.h"
#include "client/sdk/pose/motion_signals.h"
#include "client/sdk/pose/pose_tracker.h"
#include "client/sdk/prior.h"
#include "client/sdk/session_options.h"
#include "client/sdk/session_recorder.h"
#include "client/sdk/session_stats.h"
#include "client/sdk/ticket_keeper.h"

namespace dcloc::client {

/// Who numbers a scan.
enum class ScanNumber {
  kGiven,  ///< the caller has
  kNext,   ///< it follows the highest one so far
};

/// The implementation of Session: a thread that opens one stream after the other, until the session
/// ends.
///
/// Scans wait in the outbox until they are answered. Each stream begins at the oldest unanswered
/// one; the server answers those that it had processed from memory, so each is answered once.
/// Position fixes wait there too, in their place among the scans, and are sent once.
///
/// A server that knows nothing of the session may go on from its ticket. Then it gets the answered
/// scans since that ticket first, which it does not answer.
class SessionEngine final : public Connection::Host {
 public:
  /// Starts to open. `options` are valid.
  SessionEngine(std::unique_ptr<v1::LocalizationService::Stub> stub, v1::OpenSession open,
                SessionOptions options);
  ~SessionEngine() override;
  SessionEngine(const SessionEngine&) = delete;
  SessionEngine& operator=(const SessionEngine&) = delete;

  absl::Status WaitUntilOpen();
  const v1::SessionOpened& opened() const { return *first_opened_; }

  absl::Status Send(v1::Scan scan, ScanNumber number);
  absl::Status SendFix(v1::PositionFix fix);
  absl::Status AddMotion(const MotionTick& tick);
  void CloseSending();
  std::optional<v1::LocalizeResponse> Next();
  void Cancel();
  absl::Status EndStatus() const;
  absl::Status record_status() const;

  /// Begins the recording that the options ask for; the session is open.
  absl::Status StartRecording();

  SessionStats stats() const;

  /// Poses at any time, of the answers as they come; needs no lock.
  PoseTracker& poses() { return poses_; }

 private:
  using Clock = std::chrono::steady_clock;

  /// An answer that waits for `Next`, and its request where that is to be recorded.
  struct Answered {
    v1::LocalizeResponse answer;
    v1::LocalizeRequest request;
    const char* gap = nullptr;  ///< why it does not follow what is recorded; null where it does
  };

  /// Whether the application has ended the session before its end.
  enum class Stop {
    kNo,
    kCancelled,  ///< what is under way is not waited for
    kAbandoned,  ///< nor is anything that still comes taken: the engine is being destroyed
  };

  /// What the present stream may still send. A new stream begins at kOpen.
  enum class Sending {
    kOpen,       ///< scans and fixes; and `close`, once there will be no more
    kCloseSent,  ///< nothing: the client has closed the session
    kMoving,     ///< nothing: the server drains, and the next stream goes on
  };

  Connection::Fill FillRequest(v1::LocalizeRequest* request) override;
  bool HasRoom() const override;
  void Take(v1::LocalizeResponse response) override;
  void OnEnd(const grpc::Status& status) override;

  template <typename Predicate>
  absl::Status WaitForRoom(std::unique_lock<std::mutex>& lock, Predicate has_room);
  void GiveVelocity(v1::Scan& scan);
  void AddTicks(v1::Scan& scan);
  void LoseFixes(std::size_t count);
  std::optional<Answered> TakeNext();
  void Record(const std::optional<Answered>& next);
  void Run();
  absl::Status RunStream(std::unique_lock<std::mutex>& lock);
  v1::OpenSession OpenMessage() const;
  std::optional<absl::Status> Judge(const absl::Status& status);
  bool IsRefusal(const absl::Status& status);
  absl::Status Unanswered(absl::Status status) const;
  bool WaitForNextAttempt(std::unique_lock<std::mutex>& lock);
  bool FillCatchUp(v1::LocalizeRequest* request);
  void TakeOpened(v1::SessionOpened opened);
  void TakeEnding(const v1::SessionEnding& ending);
  void TakeAnswer(v1::LocalizeResponse response);
  void GiveUp(const absl::Status& status);
  void Tell(SessionEvent event);
  void DeliverEvents(std::unique_lock<std::mutex>& lock);

  const std::unique_ptr<v1::LocalizationService::Stub> stub_;
  const v1::OpenSession open_;
  const SessionOptions options_;
  PoseTracker poses_;

  std::mutex motion_mutex_;  ///< taken after the other ones
  MotionSignals motion_;
  std::int64_t newest_scan_ns_ = 0;  ///< up to which ticks have gone with scans

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Outbox outbox_;
  std::int64_t next_sequence_number_ = 0;
  std::deque<Answered> answers_;
  Prior prior_;
  TicketKeeper tickets_;
  SessionStats stats_;
  std::deque<SessionEvent> events_;  ///< not yet told
  std::optional<v1::SessionOpened> first_opened_;
  std::optional<absl::Status> end_status_;
  std::string resume_token_;
  int resume_reset_count_ = 0;   ///< attempts to resume it that were reset
  absl::Status restart_reason_;  ///< why the session before could not be resumed
  bool takes_fixes_ = false;     ///< of the newest stream's server
  bool sending_closed_ = false;
  Stop stop_ = Stop::kNo;

  mutable std::mutex record_mutex_;  ///< taken before the other one
  SessionRecorder recorder_;

  // State of the present stream.
  std::unique_ptr<Connection> connection_;
  std::optional<v1::SessionOpened> opened_;
  std::optional<absl::Status> stream_status_;
  absl::Status fault_;  ///< the server's violation of the contract
  Sending sending_ = Sending::kOpen;
  bool catches_up_ = false;          ///< the server goes on from a ticket, and needs scans first
  std::size_t caught_up_count_ = 0;  ///< of the kept scans, sent or passed over

  // Since the last progress.
  std::optional<Backoff> backoff_;
  std::optional<Clock::time_point> failing_since_;

  std::thread thread_;  ///< last: it uses the others
};

}  // namespace dcloc::client
