#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "absl/status/statusor.h"
#include "dcloc/v1/localization_service.pb.h"
#include "server/base/worker_pool.h"
#include "server/convert/session.h"
#include "server/maps/store/map_store.h"
#include "server/sessions/answer_history.h"
#include "server/sessions/scan_localizer.h"
#include "server/sessions/session_record.h"
#include "server/sessions/session_tap.h"
#include "server/telemetry/metrics.h"

namespace dcloc::server {

/// When a message arrived, on the clock that measures and on the one that tells the time.
struct Arrival {
  std::chrono::steady_clock::time_point steady;
  SystemTime system;

  static Arrival Now() {
    return {std::chrono::steady_clock::now(), std::chrono::system_clock::now()};
  }
};

/// What all sessions share; outlives them.
struct SessionContext {
  MapStore& store;
  WorkerPool& pool;    ///< answers scans
  ScanCounts& totals;  ///< of all sessions
  Metrics& metrics;
  TapRequests& taps;
  const std::string& program;  ///< for recordings
  MatcherFactory* create_matcher;
  int answer_history_count;
  std::chrono::nanoseconds detached_timeout;
};

/// One vehicle's session: from an `open` message to its last answer, over one stream or, when it is
/// resumed, several. Holds its map's version. Not thread-safe: what uses it runs on its strand.
class Session {
 public:
  /// Loads the map, which may take a while. Errors name the field: InvalidArgument, NotFound (map),
  /// FailedPrecondition (no active version, no anchor), DataLoss.
  static absl::StatusOr<std::shared_ptr<Session>> Open(const v1::OpenSession& open,
                                                       const Caller& caller,
                                                       const SessionContext& context);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Thread-safe.
  Strand& strand() { return strand_; }
  const std::shared_ptr<SessionRecord>& record() const { return record_; }

  void Describe(bool resumed, v1::SessionOpened* opened) const;

  /// Answers a scan with a result, a rejection, or what it was answered before. What `response`
  /// held before is overwritten, and its memory used again.
  void Answer(const v1::Scan& scan, const Arrival& arrival, v1::LocalizeResponse* response);

  /// Goes on in another version of the map: the last pose and its covariance are the prior at the
  /// last scan. FailedPrecondition when the maps' anchors differ, and errors of the matcher's; then
  /// nothing changes.
  absl::Status Move(LoadedMap map);

  /// Answers a scan that is not to be looked at, since newer ones wait.
  void AnswerDropped(std::int64_t sequence_number, v1::LocalizeResponse* response);

 private:
  Session(const SessionContext& context, std::shared_ptr<SessionRecord> record, LoadedMap map,
          convert::SessionRequest request, std::unique_ptr<Matcher> matcher);

  void RememberPose(const Localization& localization);
  void ChooseLane();

  void Tap(std::shared_ptr<SessionTap> tap, const v1::OpenSession& open,
           const std::string& program);
  absl::Status Localize(const v1::Scan& message, v1::LocalizationResult* result);
  absl::Status CheckOrder(const v1::Scan& message) const;
  void CountMissing(std::int64_t sequence_number);
  void Reject(std::int64_t sequence_number, const absl::Status& status,
              v1::ScanRejected* rejected) const;
  void Publish(v1::LocalizeResponse* response);
  void WarnOfBeta(const std::string& radar_id, const v1::LocalizationQuality& quality);
  void LogStages(const v1::LocalizationResult& result, std::chrono::nanoseconds encoding) const;

  const std::chrono::nanoseconds detached_timeout_;
  const int answer_history_count_;
  const std::shared_ptr<SessionRecord> record_;
  ScanCounts& totals_;
  Metrics& metrics_;
  Strand strand_;
  MatcherFactory* const create_matcher_;
  LoadedMap map_;
  Rig rig_;
  const LocalizerOptions options_;
  std::unique_ptr<Matcher> matcher_;
  std::optional<InitialPose> last_pose_;    ///< at `last_scan_`; none when it is not known
  std::set<std::string> radars_warned_of_;  ///< as their beta is contradicted
  AnswerHistory history_;
  std::shared_ptr<SessionTap> tap_;            ///< null while nobody takes it down
  std::int64_t last_sequence_number_ = -1;     ///< the highest one localized
  std::int64_t highest_sequence_number_ = -1;  ///< or dropped
  std::optional<Stamp> last_stamp_;
  std::chrono::steady_clock::time_point localized_;  ///< the newest one; what follows is encoding
  Scan scan_;                                        ///< kept for its columns' memory
  Scan last_scan_;                                   ///< the last one localized
};

}  // namespace dcloc::server
