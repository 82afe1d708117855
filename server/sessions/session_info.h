#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/geometry/pose.h"
#include "core/localizer/health.h"
#include "core/radar/radar_model.h"
#include "dcloc/v1/scan.pb.h"
#include "server/identity/caller.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/sessions/answer_feed.h"

namespace dcloc::server {

/// The part of a session that does not change.
struct SessionDescription {
  std::string session_id;
  std::string resume_token;  ///< a secret; empty unless it is resumable
  std::string vehicle_id;
  v1::Rig rig;  ///< as the client described it
  Caller caller;
  std::string map_name;
  bool map_version_asked_for = false;  ///< the client named it, so the session keeps it
  SystemTime open_time;
  bool drops_oldest = false;  ///< when its queue is full
  /// Rises with each session of the vehicle, as far as its client tells.
  std::int64_t epoch = 1;

  bool resumable() const { return !resume_token.empty(); }
};

/// Counts of a session's scans by their result; written by the session, read by any thread.
struct ScanCounts {
  std::atomic<std::int64_t> answered = 0;
  std::atomic<std::int64_t> rejected = 0;  ///< malformed or late
  std::atomic<std::int64_t> repeated = 0;  ///< answered from memory
  std::atomic<std::int64_t> dropped = 0;
};

/// The health of a session's last answer. Thread-safe.
class LastHealth {
 public:
  struct Value {
    Health health;
    std::shared_ptr<const Rig> rig;  ///< null before the first answer
  };

  void Set(const Health& health, const std::shared_ptr<const Rig>& rig) {
    const std::lock_guard lock(mutex_);
    if (value_.rig == rig && value_.health == health) return;
    value_ = {.health = health, .rig = rig};
  }

  Value Get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  Value value_;
};

/// The pose of a session's last answer, for lists. Thread-safe; its lock is this session's alone.
class LastPose {
 public:
  struct Value {
    std::int64_t stamp_ns = 0;  ///< of the answered scan
    Pose3 T_map_vehicle;
    Matrix6d covariance;  ///< in the tangent space on the right of `T_map_vehicle`
  };

  /// None where no pose is known.
  void Set(const std::optional<Value>& value) {
    const std::lock_guard lock(mutex_);
    value_ = value;
  }

  std::optional<Value> Get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  std::optional<Value> value_;
};

/// The parts of a session that other threads may read.
struct SessionInfo {
  using Clock = std::chrono::steady_clock;

  SessionDescription description;
  std::atomic<std::int64_t> map_version = 0;
  std::atomic<bool> recorded = false;  ///< from its opening on, and so in one version
  ScanCounts counts;
  std::atomic<std::int64_t> missing_scan_count = 0;
  std::atomic<std::int64_t> position_fix_count = 0;
  std::atomic<std::int64_t> pose_reset_count = 0;
  std::atomic<std::int64_t> resume_count = 0;
  std::atomic<std::int64_t> last_sequence_number = -1;  ///< the highest one processed, or -1
  std::atomic<std::int64_t> last_stamp_age_ns = 0;      ///< arrival minus stamp
  /// Of the last answer; a LocalizationState, or -1 before the first one.
  std::atomic<int> last_state = -1;
  std::atomic<Clock::time_point> last_activity = Clock::now();
  LastHealth health;
  LastPose pose;
  AnswerFeed feed;
};

}  // namespace dcloc::server
