#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/localizer/health.h"
#include "core/localizer/pose_resets.h"

namespace dcloc::server {

enum class SourceKind : std::size_t { kWheelSpeed, kYawRate, kRadar };
inline constexpr std::array<const char*, 3> kSourceKindNames = {"wheel_speed", "yaw_rate", "radar"};

/// A source that was set aside, taken back, or is set aside for another reason.
struct SourceChange {
  SourceKind kind = SourceKind::kRadar;
  std::size_t radar_index = 0;  ///< in the rig, of a radar
  SourceHealth health;
  int change_count = 0;  ///< since it was last logged, this one included
};

/// What has changed in a session's health.
struct HealthChanges {
  std::vector<SourceChange> sources;
  std::array<bool, kSourceKindNames.size()> set_aside{};  ///< one of that kind is, logged or not
  int new_reset_count = 0;
  bool reset_is_logged = false;  ///< too frequent ones are counted with the next logged one
};

/// Decides what of a session's health is logged, so that a source that flaps floods no log: for
/// each source at most one change in ten seconds, and the same for resets. A source that has never
/// been used is not missed while it is silent. Not thread-safe.
class HealthWatch {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kQuiet{10};

  HealthChanges Observe(const Health& health, const PoseResets& resets, Clock::time_point now);

 private:
  struct Source {
    bool is_known = false;  ///< it has been used, or found faulty
    SourceHealth logged = {.is_used = true, .fault = SourceFault::kNone};
    SourceHealth seen = {.is_used = true, .fault = SourceFault::kNone};
    int change_count = 0;
    std::optional<Clock::time_point> logged_time;
  };

  static void Observe(const SourceHealth& health, SourceChange change, Clock::time_point now,
                      Source* source, HealthChanges* changes);
  void Observe(const PoseResets& resets, Clock::time_point now, HealthChanges* changes);

  Source wheel_speed_;
  Source yaw_rate_;
  std::vector<Source> radars_;
  int reset_count_ = 0;
  std::optional<Clock::time_point> reset_time_;
};

}  // namespace dcloc::server
