#include "core/odometry/tick_motion.h"

#include <algorithm>
#include <iterator>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

constexpr std::chrono::nanoseconds kMaxGap = std::chrono::milliseconds(250);
constexpr std::chrono::nanoseconds kHeld = std::chrono::milliseconds(50);

/// Between ticks on a straight line, after the last one as that. `stamp` is not before the first.
MotionTick TickAt(std::span<const MotionTick> ticks, Stamp stamp) {
  const auto after = std::ranges::upper_bound(ticks, stamp, {}, &MotionTick::stamp);
  const MotionTick& a = *std::prev(after);
  if (after == ticks.end()) return {stamp, a.speed_mps, a.yaw_rate_radps};
  const double share = SecondsOf(stamp - a.stamp) / SecondsOf(after->stamp - a.stamp);
  return {stamp, a.speed_mps + share * (after->speed_mps - a.speed_mps),
          a.yaw_rate_radps + share * (after->yaw_rate_radps - a.yaw_rate_radps)};
}

/// From the one to the other, if the velocity changes evenly.
Pose3 Step(const MotionTick& a, const MotionTick& b) {
  const double half_s = 0.5 * SecondsOf(b.stamp - a.stamp);
  Vector6d twist = Vector6d::Zero();
  twist(0) = half_s * (a.speed_mps + b.speed_mps);
  twist(5) = half_s * (a.yaw_rate_radps + b.yaw_rate_radps);
  return Exp(twist);
}

bool Reach(std::span<const MotionTick> ticks, Stamp begin, Stamp end) {
  if (ticks.empty() || ticks.front().stamp > begin || ticks.back().stamp + kHeld < end) {
    return false;
  }
  return std::ranges::adjacent_find(ticks, [](const MotionTick& a, const MotionTick& b) {
           return b.stamp - a.stamp > kMaxGap;
         }) == ticks.end();
}

}  // namespace

std::optional<Pose3> BeyondTheLine(std::span<const MotionTick> ticks, Stamp begin, Stamp end) {
  if (begin >= end || !Reach(ticks, begin, end)) return std::nullopt;
  const MotionTick first = TickAt(ticks, begin);
  const MotionTick last = TickAt(ticks, end);
  Pose3 T_begin_now;
  MotionTick now = first;
  for (const MotionTick& tick : ticks) {
    if (tick.stamp <= begin || tick.stamp >= end) continue;
    T_begin_now = T_begin_now * Step(now, tick);
    now = tick;
  }
  return Step(first, last).Inverse() * (T_begin_now * Step(now, last));
}

}  // namespace dcloc
