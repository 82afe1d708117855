#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "dcloc/v1/localization_service.pb.h"
#include "server/base/worker_pool.h"
#include "server/convert/answer.h"
#include "server/convert/position_fix.h"
#include "server/convert/session.h"
#include "server/maps/store/map_store.h"
#include "server/passes/pass_tap.h"
#include "server/sessions/answer_history.h"
#include "server/sessions/health_report.h"
#include "server/sessions/recording_subscriber.h"
#include "server/sessions/scan_localizer.h"
#include "server/sessions/sequence_number_check.h"
#include "server/sessions/session_info.h"
#include "server/sessions/session_metrics.h"
#include "server/sessions/ticket_writer.h"
#include "server/tickets/session_tickets.h"

namespace dcloc::server {

/// When a message arrived, on the clock that measures and on the one that tells the time.
struct Arrival {
  std::chrono::steady_clock::time_point steady;
  SystemTime system;

  static Arrival Now() {
    return {std::chrono::steady_clock::now(), std::chrono::system_clock::now()};
  }
};

/// What all sessions share; the references outlive them.
struct SessionContext {
  WorkerPool& pool;    ///< answers scans
  ScanCounts& totals;  ///< of all sessions
  SessionMetrics& metrics;
  ScanLocalizerFactory create_localizer;
  int answer_history_count;
  std::chrono::nanoseconds detached_timeout;
  const SessionTickets* tickets;  ///< null without a fleet key
};

/// What a session starts from.
struct SessionStart {
  std::shared_ptr<SessionInfo> info;
  LoadedMap map;
  Rig rig;
  LocalizerOptions options;
  std::optional<InitialPose> initial_pose;
  TicketBinding binding;  ///< of the session's tickets
  TicketUse ticket_use = TicketUse::kNone;
  std::optional<TicketContent> ticket;  ///< which it goes on from
  /// With a ticket: scans up to it need no answer, as they have had one.
  std::optional<std::int64_t> answered_until;
  std::unique_ptr<PassTap> passes;  ///< null where what it sees is not kept
};

/// One vehicle's session: from its opening to its last answer, over one stream or, when it is
/// resumed, several. Holds its map's version. It hands each answer as a plain value to the stream,
/// to those who watch or record it, to the metrics, and keeps the last ones. Not thread-safe:
/// everything that uses it runs on its strand.
class Session {
 public:
  /// Receives each scan's answer, to convert it into a message.
  using Reply = absl::FunctionRef<void(const ScanAnswer& answer)>;
  using FixReply = absl::FunctionRef<void(const FixAnswer& answer)>;

  /// Errors of the localizer's.
  static absl::StatusOr<std::shared_ptr<Session>> Create(const SessionContext& context,
                                                         SessionStart start);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Thread-safe.
  Strand& strand() { return strand_; }
  const std::shared_ptr<SessionInfo>& info() const { return info_; }

  OpenedSession Describe(bool resumed) const;

  /// What became of the ticket that it was opened with.
  TicketUse ticket_use() const { return ticket_use_; }

  /// `subscriber` gets what comes from now on; the session then stays in its map's version. Without
  /// memory its recording ends, and the session goes on. To be called before the first scan, with
  /// the message that opened the session.
  void Record(std::shared_ptr<RecordingSubscriber> subscriber, const v1::OpenSession& open);

  /// Answers a scan: with a result, a rejection, or the answer that it got before.
  void Answer(const v1::Scan& scan, const Arrival& arrival, Reply reply);

  /// Whether the vehicle may have had the answer to a scan from another session, which this one
  /// goes on from. Thread-safe.
  bool MayCatchUp(std::int64_t sequence_number) const {
    return answered_until_ && sequence_number >= 0 && sequence_number <= *answered_until_;
  }

  /// True if the vehicle already has this scan's answer and the scan is newer than the last one
  /// localized: it is localized, and nothing is sent. Clients catch up in the order of numbers, so
  /// an older scan was late before too and still waits for its answer.
  bool IsToCatchUp(std::int64_t sequence_number) const {
    return MayCatchUp(sequence_number) && sequence_number > sequence_check_.last_localized();
  }

  /// Localizes such a scan, for those that follow. Nothing is sent.
  void CatchUp(const v1::Scan& scan);

  /// Answers a scan that is dropped because newer ones wait.
  void AnswerDropped(std::int64_t sequence_number, Reply reply);

  /// Takes in a position fix and answers it.
  void TakeFix(const v1::PositionFix& fix, FixReply reply);

  /// Takes in a pose that somebody proposes for `fix.stamp_ns`, or for the last scan where that is
  /// 0, as a position fix. FailedPrecondition, and nothing changes: before the first scan, or while
  /// the session is recorded by somebody who cannot keep fixes. Other errors are in the answer.
  absl::StatusOr<FixAnswer> ProposePose(v1::PositionFix fix);

  /// Goes on in another version of the map: the last pose and its covariance are the prior at the
  /// last scan. FailedPrecondition when the maps' anchors differ, and errors of the localizer's;
  /// then nothing changes.
  absl::Status Move(LoadedMap map);

 private:
  using Clock = std::chrono::steady_clock;

  Session(const SessionContext& context, SessionStart start,
          std::unique_ptr<ScanLocalizer> localizer);

  bool AnswerFromHistory(std::int64_t sequence_number, Reply reply);
  absl::StatusOr<LocalizedScan> Localize(const v1::Scan& message);
  absl::Status TakeScan(const v1::Scan& message, Clock::time_point begin);
  void OnLocalized(const v1::Scan& message, const Localization& localization);
  absl::StatusOr<FixUse> Use(const v1::PositionFix& message);
  void RememberPose(const Localization& localization);
  void ChooseLane();
  void Count(const ScanAnswer& answer);
  void WarnOfBeta(const std::string& radar_id, const BetaCheck& beta);
  void Deliver(const v1::Scan& scan, ScanAnswer& answer, Reply reply);

  const SessionContext context_;
  const std::shared_ptr<SessionInfo> info_;
  Strand strand_;
  LoadedMap map_;
  const std::shared_ptr<const Rig> rig_;
  const LocalizerOptions options_;
  std::unique_ptr<ScanLocalizer> localizer_;
  std::optional<InitialPose> last_pose_;  ///< at `last_scan_`; none when it is not known
  PoseResets last_resets_;                ///< of the last answer
  PoseResets resets_before_move_;         ///< of the localizers before this one
  HealthReport health_;
  std::set<std::string> radars_warned_of_;  ///< as their beta is contradicted
  SequenceNumberCheck sequence_check_;
  TicketWriter ticket_writer_;
  const TicketUse ticket_use_;
  float usual_target_count_ = 0.0F;  ///< of the largest of the last scans; falls slowly
  const std::optional<std::int64_t> answered_until_;
  AnswerHistory history_;
  std::shared_ptr<RecordingSubscriber> recording_;  ///< null while nobody records it
  const std::unique_ptr<PassTap> passes_;           ///< null where what it sees is not kept
  Clock::time_point localized_time_;  ///< of the newest scan; what follows is encoding
  Scan scan_;                         ///< kept for its columns' memory
  Scan last_scan_;                    ///< the last one localized
};

}  // namespace dcloc::server
