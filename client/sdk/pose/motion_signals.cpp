#include "client/sdk/pose/motion_signals.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "absl/strings/str_cat.h"

namespace dcloc::client {
namespace {

constexpr std::int64_t kKept_ns = 1'500'000'000;
constexpr std::int64_t kMaxAge_ns = 100'000'000;
// Ticks of a longer time than this do not go with a scan, and no more of them: the server takes
// 1,000 from within two seconds.
constexpr std::int64_t kMaxTicksSpan_ns = 1'000'000'000;
constexpr std::size_t kMaxTickCount = 200;
constexpr double kMaxSpeed_mps = 150.0;
constexpr double kMaxTurnRate_radps = 10.0;

absl::Status Check(const char* field, const std::optional<double>& value, double bound) {
  if (!value || std::abs(*value) <= bound) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", *value, "; it must lie in [", -bound, ", ", bound, "]"));
}

}  // namespace

absl::Status MotionSignals::Add(const MotionTick& tick) {
  if (tick.stamp_ns <= 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("stamp_ns is ", tick.stamp_ns, "; it must be positive"));
  }
  absl::Status status = Check("speed_mps", tick.speed_mps, kMaxSpeed_mps);
  status.Update(Check("yaw_rate_radps", tick.yaw_rate_radps, kMaxTurnRate_radps));
  if (status.ok() && !tick.speed_mps && !tick.yaw_rate_radps) {
    status = absl::InvalidArgumentError("a tick has neither speed_mps nor yaw_rate_radps");
  }
  if (!status.ok()) return status;
  if (tick.stamp_ns < newest_ns_ - kKept_ns) {
    speed_mps_.clear();
    yaw_rate_radps_.clear();
    newest_ns_ = 0;
  }
  newest_ns_ = std::max(newest_ns_, tick.stamp_ns);
  if (tick.speed_mps) Insert({tick.stamp_ns, *tick.speed_mps}, speed_mps_);
  if (tick.yaw_rate_radps) Insert({tick.stamp_ns, *tick.yaw_rate_radps}, yaw_rate_radps_);
  return status;
}

/// Where its stamp belongs, in place of one that has the same; forgets what is old.
void MotionSignals::Insert(const Sample& sample, Signal& signal) {
  const auto place = std::ranges::lower_bound(signal, sample.stamp_ns, {}, &Sample::stamp_ns);
  if (place != signal.end() && place->stamp_ns == sample.stamp_ns) {
    *place = sample;
  } else {
    signal.insert(place, sample);
  }
  while (signal.front().stamp_ns < signal.back().stamp_ns - kKept_ns) signal.pop_front();
}

std::optional<double> MotionSignals::At(const Signal& signal, std::int64_t stamp_ns) {
  const auto after = std::ranges::lower_bound(signal, stamp_ns, {}, &Sample::stamp_ns);
  const bool has_after = after != signal.end();
  const bool has_before = after != signal.begin();
  if (has_after && after->stamp_ns == stamp_ns) return after->value;
  if (has_before && has_after) {
    const Sample& before = *std::prev(after);
    const double share = static_cast<double>(stamp_ns - before.stamp_ns) /
                         static_cast<double>(after->stamp_ns - before.stamp_ns);
    return before.value + share * (after->value - before.value);
  }
  if (!has_before && !has_after) return std::nullopt;
  const Sample& nearest = has_after ? *after : signal.back();
  if (std::abs(nearest.stamp_ns - stamp_ns) > kMaxAge_ns) return std::nullopt;
  return nearest.value;
}

// From the last one not after `from_ns` to the first one not before `to_ns`, as far as they are
// near.
void MotionSignals::AddAround(const Signal& signal, std::int64_t from_ns, std::int64_t to_ns,
                              std::set<std::int64_t>& stamps_ns) {
  auto first = std::ranges::upper_bound(signal, from_ns, {}, &Sample::stamp_ns);
  if (first != signal.begin()) --first;
  for (; first != signal.end(); ++first) {
    if (first->stamp_ns > to_ns + kMaxAge_ns) return;
    if (first->stamp_ns >= from_ns - kMaxAge_ns) stamps_ns.insert(first->stamp_ns);
    if (first->stamp_ns >= to_ns) return;
  }
}

v1::MotionTicks MotionSignals::TicksAround(std::int64_t from_ns, std::int64_t to_ns) const {
  v1::MotionTicks ticks;
  if (to_ns - from_ns > kMaxTicksSpan_ns) return ticks;
  std::set<std::int64_t> stamps_ns;
  AddAround(speed_mps_, from_ns, to_ns, stamps_ns);
  AddAround(yaw_rate_radps_, from_ns, to_ns, stamps_ns);
  const std::size_t stride = 1 + stamps_ns.size() / kMaxTickCount;
  std::size_t index = 0;
  for (const std::int64_t stamp_ns : stamps_ns) {
    const bool is_last = index + 1 == stamps_ns.size();
    if (index++ % stride != 0 && !is_last) continue;
    const std::optional<double> speed_mps = At(speed_mps_, stamp_ns);
    const std::optional<double> yaw_rate_radps = At(yaw_rate_radps_, stamp_ns);
    if (!speed_mps || !yaw_rate_radps) continue;
    ticks.add_stamp_offset_ns(stamp_ns - to_ns);
    ticks.add_speed_mps(static_cast<float>(*speed_mps));
    ticks.add_yaw_rate_radps(static_cast<float>(*yaw_rate_radps));
  }
  return ticks;
}

std::optional<v1::EgoVelocity> MotionSignals::VelocityAt(std::int64_t stamp_ns) const {
  const std::optional<double> speed_mps = At(speed_mps_, stamp_ns);
  const std::optional<double> yaw_rate_radps = At(yaw_rate_radps_, stamp_ns);
  if (!speed_mps || !yaw_rate_radps) return std::nullopt;
  v1::EgoVelocity velocity;
  velocity.mutable_linear_mps()->set_x(*speed_mps);
  velocity.mutable_angular_radps()->set_z(*yaw_rate_radps);
  return velocity;
}

}  // namespace dcloc::client
