#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "dcloc/v1/localization_service.pb.h"
#include "server/localization/matcher.h"
#include "server/localization/session_registry.h"
#include "server/maps/map_store.h"

namespace dcloc::server {

/// One vehicle's session: from an `open` message to its last answer. Holds its map's version. Not
/// thread-safe.
class Session {
 public:
  /// Loads the map, which may take a while. `registry` outlives the session. Errors name the field:
  /// InvalidArgument, NotFound (map), FailedPrecondition (no active version, no anchor), DataLoss.
  static absl::StatusOr<std::unique_ptr<Session>> Open(const v1::OpenSession& open,
                                                       const std::string& peer, MapStore& store,
                                                       SessionRegistry& registry,
                                                       MatcherFactory* create_matcher);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  void Describe(v1::SessionOpened* opened) const;

  /// Answers a scan that arrived at `arrival` with a result or a rejection. What `response` held
  /// before is overwritten, and its memory used again.
  void Answer(const v1::Scan& scan, std::chrono::steady_clock::time_point arrival,
              v1::LocalizeResponse* response);

 private:
  Session(std::shared_ptr<SessionRecord> record, ScanCounts& totals, LoadedMap map, Rig rig,
          std::unique_ptr<Matcher> matcher);

  absl::Status Localize(const v1::Scan& message, v1::LocalizationResult* result);
  void Reject(const v1::Scan& message, const absl::Status& status, v1::ScanRejected* rejected);

  std::shared_ptr<SessionRecord> record_;
  ScanCounts& totals_;
  LoadedMap map_;
  Rig rig_;
  std::unique_ptr<Matcher> matcher_;
  std::int64_t last_sequence_number_ = -1;
  Scan scan_;  ///< kept for its columns' memory
};

}  // namespace dcloc::server
