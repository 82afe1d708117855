#include "client/datasets/check/velocity_check.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "core/geometry/covariance.h"
#include "core/geometry/pose.h"

namespace dcloc {
namespace {

constexpr double kStep_s = 0.2;  ///< motions are compared over so long, as poses have noise
constexpr double kMaxStep_s = 1.0;
constexpr double kMaxDelay_s = 0.6;
constexpr double kDelayStep_s = 0.02;
constexpr std::size_t kMinSteps = 20;
/// A factor is told where its standard error is no larger.
constexpr double kMaxFactorSigma = 0.03;
/// The best delay leaves at most this share of the squared differences that none leaves.
constexpr double kTellingShare = 0.4;
/// And those that none leaves are at least this [m/s, rad/s], root mean square.
constexpr double kTellingSpeed_mps = 0.1;
constexpr double kTellingYawRate_radps = 0.01;

/// Speed [m/s] or yaw rate [rad/s] at a moment [s] since the drive's begin.
struct Sample {
  double time_s;
  double value;
};
using Signal = std::vector<Sample>;

/// Between samples on a straight line; nothing beyond them, and where they are far apart.
std::optional<double> At(const Signal& signal, double time_s) {
  const auto after = std::ranges::lower_bound(signal, time_s, {}, &Sample::time_s);
  if (after == signal.begin() || after == signal.end()) return std::nullopt;
  const Sample& a = *std::prev(after);
  if (after->time_s - a.time_s > kMaxStep_s) return std::nullopt;
  const double share = (time_s - a.time_s) / (after->time_s - a.time_s);
  return a.value + share * (after->value - a.value);
}

/// What was reported beside the truth, as far as both are known.
std::vector<std::pair<double, double>> Pairs(const Signal& reported, const Signal& truth,
                                             double delay_s) {
  std::vector<std::pair<double, double>> pairs;
  for (const Sample& sample : truth) {
    if (const auto value = At(reported, sample.time_s + delay_s)) {
      pairs.emplace_back(*value, sample.value);
    }
  }
  return pairs;
}

/// Least squares of reported = factor * truth.
struct FactorFit {
  double factor = 1.0;
  double left = 0.0;   ///< the mean squared difference
  double sigma = 0.0;  ///< standard error of the factor
};

/// Where `reported` is later by `delay_s`.
std::optional<FactorFit> FitOf(const Signal& reported, const Signal& truth, double delay_s) {
  const auto pairs = Pairs(reported, truth, delay_s);
  if (pairs.size() < kMinSteps) return std::nullopt;
  double values = 0.0;
  double product = 0.0;
  double square = 0.0;
  for (const auto& [value, expected] : pairs) {
    values += value * value;
    product += value * expected;
    square += expected * expected;
  }
  if (square <= 0.0) return std::nullopt;
  const double factor = product / square;
  const double left = std::max(0.0, values - factor * product) / static_cast<double>(pairs.size());
  return FactorFit{.factor = factor, .left = left, .sigma = std::sqrt(left / square)};
}

std::optional<double> FactorOf(const Signal& reported, const Signal& truth) {
  const std::optional<FactorFit> fit = FitOf(reported, truth, 0.0);
  return fit && fit->sigma <= kMaxFactorSigma ? std::optional(fit->factor) : std::nullopt;
}

std::optional<double> DelayOf(const Signal& reported, const Signal& truth, double telling_rms) {
  const std::optional<FactorFit> without = FitOf(reported, truth, 0.0);
  if (!without || without->left < telling_rms * telling_rms) return std::nullopt;
  double best_s = 0.0;
  double best = without->left;
  for (double delay_s = -kMaxDelay_s; delay_s <= kMaxDelay_s; delay_s += kDelayStep_s) {
    const std::optional<FactorFit> fit = FitOf(reported, truth, delay_s);
    if (fit && fit->left < best) {
      best = fit->left;
      best_s = delay_s;
    }
  }
  return best <= kTellingShare * without->left ? std::optional(best_s) : std::nullopt;
}

struct Signals {
  Signal speed;
  Signal yaw_rate;
};

double Seconds(const Drive& drive, std::size_t index) {
  return std::chrono::duration<double>(drive.scans[index].scan.stamp -
                                       drive.scans.front().scan.stamp)
      .count();
}

Signals Reported(const Drive& drive) {
  Signals signals;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const auto& velocity = drive.scans[i].scan.ego_velocity;
    const double time_s = Seconds(drive, i);
    if (!velocity || (!signals.speed.empty() && signals.speed.back().time_s == time_s)) continue;
    signals.speed.push_back({time_s, velocity->linear_mps.x()});
    signals.yaw_rate.push_back({time_s, velocity->angular_radps.z()});
  }
  return signals;
}

/// From pose to pose; each is of the middle of its step.
Signals ByPoses(const Drive& drive) {
  Signals signals;
  std::size_t begin = 0;
  for (std::size_t i = 1; i < drive.scans.size(); ++i) {
    const double duration_s = Seconds(drive, i) - Seconds(drive, begin);
    if (duration_s < kStep_s) continue;
    if (duration_s <= kMaxStep_s) {
      const Vector6d twist =
          Log(drive.scans[begin].T_map_vehicle.Inverse() * drive.scans[i].T_map_vehicle) /
          duration_s;
      const double middle_s = Seconds(drive, begin) + 0.5 * duration_s;
      signals.speed.push_back({middle_s, twist(0)});
      signals.yaw_rate.push_back({middle_s, twist(5)});
    }
    begin = i;
  }
  return signals;
}

}  // namespace

VelocityCheck CheckVelocities(const Drive& drive) {
  VelocityCheck check{.scan_count = drive.scans.size()};
  if (drive.velocity_source != VelocitySource::kVehicle) return check;
  check.velocity_count = static_cast<std::size_t>(std::ranges::count_if(
      drive.scans, [](const DriveScan& entry) { return entry.scan.ego_velocity.has_value(); }));
  if (drive.pose_source != PoseSource::kReference || drive.scans.empty()) return check;
  const Signals reported = Reported(drive);
  const Signals truth = ByPoses(drive);
  check.speed_factor = FactorOf(reported.speed, truth.speed);
  check.yaw_rate_factor = FactorOf(reported.yaw_rate, truth.yaw_rate);
  check.delay_s = DelayOf(reported.speed, truth.speed, kTellingSpeed_mps);
  if (!check.delay_s) {
    check.delay_s = DelayOf(reported.yaw_rate, truth.yaw_rate, kTellingYawRate_radps);
  }
  return check;
}

}  // namespace dcloc
