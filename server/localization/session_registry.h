#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>
#include "absl/strings/string_view.h"

#include "core/localizer/localizer.h"
#include "server/maps/catalogue.h"

namespace dcloc::server {

/// What can be told of an open session.
struct SessionDescription {
  std::string session_id;
  std::string vehicle_id;
  std::string peer;
  std::string map_name;
  std::int64_t map_version = 0;
  SystemTime open_time;
};

/// What its scans came to; written by the session, read by anyone.
struct ScanCounts {
  std::atomic<std::int64_t> answered = 0;
  std::atomic<std::int64_t> rejected = 0;
};

struct SessionRecord {
  SessionDescription description;
  ScanCounts counts;
  /// Of the last answer; a LocalizationState, or -1 before the first one.
  std::atomic<int> last_state = -1;
};

/// The sessions that are open, and the counts of all that ever were. Thread-safe; nothing on a
/// scan's path takes its lock.
class SessionRegistry {
 public:
  /// The session is listed for as long as the record is held.
  std::shared_ptr<SessionRecord> Add(SessionDescription description);

  /// At most `limit` sessions with an id above `after_id`, by ascending id.
  std::vector<std::shared_ptr<const SessionRecord>> List(absl::string_view after_id,
                                                         int limit) const;

  int count() const;
  ScanCounts& totals() { return totals_; }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::weak_ptr<SessionRecord>, std::less<>> records_;
  ScanCounts totals_;
};

}  // namespace dcloc::server
