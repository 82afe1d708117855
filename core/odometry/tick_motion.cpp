#include "core/odometry/tick_motion.h"

#include <algorithm>
#include <iterator>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

using std::chrono::nanoseconds;

// Slow buses report ten times a second. In a gap of two reports and a half, the velocity may have
// been anything.
constexpr nanoseconds kMaxGap = std::chrono::milliseconds(250);
// A scan is sent before the next tick has come: buses report fifty times a second, two in a row may
// be lost.
constexpr nanoseconds kHeld = std::chrono::milliseconds(50);

// Between ticks on a straight line; after the last one as that. `when` is not before the first.
MotionTick TickAt(std::span<const MotionTick> ticks, nanoseconds when) {
  const auto after = std::ranges::upper_bound(ticks, when, {}, &MotionTick::after_scan);
  const MotionTick& a = *std::prev(after);
  if (after == ticks.end()) return {when, a.speed_mps, a.yaw_rate_radps};
  const double share = SecondsOf(when - a.after_scan) / SecondsOf(after->after_scan - a.after_scan);
  return {when, a.speed_mps + share * (after->speed_mps - a.speed_mps),
          a.yaw_rate_radps + share * (after->yaw_rate_radps - a.yaw_rate_radps)};
}

// From the one to the other, if the velocity changes evenly.
Pose3 Step(const MotionTick& a, const MotionTick& b) {
  const double half_s = 0.5 * SecondsOf(b.after_scan - a.after_scan);
  Vector6d twist = Vector6d::Zero();
  twist(0) = half_s * (a.speed_mps + b.speed_mps);
  twist(5) = half_s * (a.yaw_rate_radps + b.yaw_rate_radps);
  return Exp(twist);
}

bool ReachOver(std::span<const MotionTick> ticks, nanoseconds begin, nanoseconds end) {
  if (ticks.empty() || ticks.front().after_scan > begin || ticks.back().after_scan + kHeld < end) {
    return false;
  }
  return std::ranges::adjacent_find(ticks, [](const MotionTick& a, const MotionTick& b) {
           return b.after_scan - a.after_scan > kMaxGap;
         }) == ticks.end();
}

}  // namespace

std::optional<Pose3> BeyondTheLine(std::span<const MotionTick> ticks, nanoseconds age) {
  const nanoseconds begin = -age, end{0};
  if (begin >= end || !ReachOver(ticks, begin, end)) return std::nullopt;
  const MotionTick first = TickAt(ticks, begin);
  const MotionTick last = TickAt(ticks, end);
  Pose3 T_begin_now;
  MotionTick now = first;
  for (const MotionTick& tick : ticks) {
    if (tick.after_scan <= begin || tick.after_scan >= end) continue;
    T_begin_now = T_begin_now * Step(now, tick);
    now = tick;
  }
  return Step(first, last).Inverse() * (T_begin_now * Step(now, last));
}

}  // namespace dcloc
