#include "server/sessions/health_watch.h"

namespace dcloc::server {
namespace {

using WatchClock = HealthWatch::Clock;

bool IsDue(const std::optional<WatchClock::time_point>& last, WatchClock::time_point now) {
  return !last || now - *last >= HealthWatch::kQuiet;
}

/// Sources that are used are alike, whatever is corrected of them.
bool IsTheSame(const SourceHealth& a, const SourceHealth& b) {
  return a.is_used == b.is_used && (a.is_used || a.fault == b.fault);
}

}  // namespace

HealthChanges HealthWatch::Observe(const Health& health, const PoseResets& resets,
                                   Clock::time_point now) {
  HealthChanges changes;
  Observe(health.wheel_speed, {.kind = SourceKind::kWheelSpeed}, now, &wheel_speed_, &changes);
  Observe(health.yaw_rate, {.kind = SourceKind::kYawRate}, now, &yaw_rate_, &changes);
  radars_.resize(health.radars.size());
  for (std::size_t i = 0; i < radars_.size(); ++i) {
    Observe(health.radars[i], {.kind = SourceKind::kRadar, .radar_index = i}, now, &radars_[i],
            &changes);
  }
  Observe(resets, now, &changes);
  return changes;
}

void HealthWatch::Observe(const SourceHealth& health, SourceChange change, Clock::time_point now,
                          Source* source, HealthChanges* changes) {
  source->is_known = source->is_known || health.is_used || health.fault != SourceFault::kSilent;
  if (!source->is_known) return;
  if (!health.is_used) changes->set_aside[static_cast<std::size_t>(change.kind)] = true;
  if (!IsTheSame(health, source->seen)) ++source->change_count;
  source->seen = health;
  if (IsTheSame(health, source->logged) || !IsDue(source->logged_time, now)) return;
  change.health = health;
  change.change_count = source->change_count;
  changes->sources.push_back(change);
  source->logged = health;
  source->logged_time = now;
  source->change_count = 0;
}

void HealthWatch::Observe(const PoseResets& resets, Clock::time_point now, HealthChanges* changes) {
  changes->new_reset_count = resets.count - reset_count_;
  reset_count_ = resets.count;
  if (changes->new_reset_count <= 0 || !IsDue(reset_time_, now)) return;
  changes->reset_is_logged = true;
  reset_time_ = now;
}

}  // namespace dcloc::server
