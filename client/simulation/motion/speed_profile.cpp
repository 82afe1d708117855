#include "client/simulation/motion/speed_profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace dcloc::simulation {
namespace {

constexpr double kGrid = 0.5;       // [m] along the path
constexpr double kTimeStep = 0.02;  // [s]
constexpr double kMinSpeed = 0.4;   // above zero, so that a halt is reached in finite time [m/s]
constexpr std::size_t kSmoothing =
    25;  // half width of the box that rounds the accelerations, in steps
constexpr double kFastestCruise = 1.5;  // of the mean speed

// Speeds at grid points of the path for a given cruising speed.
class SpeedLimits {
 public:
  SpeedLimits(const Path& path, const SpeedProfileOptions& options, Random& random)
      : options_(options) {
    const std::array<double, 3> phases = {Uniform(random, 0.0, 6.28), Uniform(random, 0.0, 6.28),
                                          Uniform(random, 0.0, 6.28)};
    const auto count = static_cast<std::size_t>((options.end_m - options.begin_m) / kGrid) + 2;
    for (std::size_t i = 0; i < count; ++i) {
      const double s = options.begin_m + kGrid * static_cast<double>(i);
      mood_.push_back(1.0 + 0.06 * std::sin(s / 30.0 + phases[0]) +
                      0.05 * std::sin(s / 70.0 + phases[1]) +
                      0.05 * std::sin(s / 160.0 + phases[2]));
      const double curvature = std::abs(path.At(s).curvature_per_m);
      bend_mps_.push_back(
          std::sqrt(options.max_lateral_acceleration_mps2 / std::max(curvature, 1e-6)));
    }
    for (const double stop_m : options.stops_m) {
      const auto i = static_cast<std::size_t>((stop_m - options.begin_m) / kGrid);
      if (stop_m > options.begin_m && i < count) bend_mps_[i] = kMinSpeed;
    }
  }

  std::vector<double> For(double cruise_mps) const {
    std::vector<double> speed(mood_.size());
    for (std::size_t i = 0; i < speed.size(); ++i) {
      speed[i] = std::max(kMinSpeed, std::min(cruise_mps * mood_[i], bend_mps_[i]));
    }
    const auto bound = [](double neighbour, double acceleration) {
      return std::sqrt(neighbour * neighbour + 2.0 * acceleration * kGrid);
    };
    for (std::size_t i = 1; i < speed.size(); ++i) {
      speed[i] = std::min(speed[i], bound(speed[i - 1], options_.max_acceleration_mps2));
    }
    for (std::size_t i = speed.size() - 1; i > 0; --i) {
      speed[i - 1] = std::min(speed[i - 1], bound(speed[i], options_.max_braking_mps2));
    }
    return speed;
  }

 private:
  const SpeedProfileOptions& options_;
  std::vector<double> mood_;
  std::vector<double> bend_mps_;
};

double DriveTime(const std::vector<double>& speed) {
  double time_s = 0.0;
  for (std::size_t i = 1; i < speed.size(); ++i) time_s += 2.0 * kGrid / (speed[i - 1] + speed[i]);
  return time_s;
}

std::vector<double> SpeedsForMean(const SpeedLimits& limits, double wanted_time_s,
                                  double mean_mps) {
  double low = 0.5 * mean_mps;
  double high = kFastestCruise * mean_mps;
  for (int i = 0; i < 40; ++i) {
    const double cruise = 0.5 * (low + high);
    (DriveTime(limits.For(cruise)) > wanted_time_s ? low : high) = cruise;
  }
  return limits.For(high);
}

// Speeds by time, with the halts in; then a box filter bounds the jerk and keeps the distance.
std::vector<double> SpeedsByTime(const std::vector<double>& speed,
                                 const SpeedProfileOptions& options,
                                 const std::vector<double>& halts_s) {
  const double length_m = options.end_m - options.begin_m;
  std::vector<double> by_time(kSmoothing, speed.front());
  std::size_t next_stop = 0;
  double s = 0.0;
  while (s < length_m + static_cast<double>(2 * kSmoothing) * kTimeStep * speed.back()) {
    const double grid = std::min(s / kGrid, static_cast<double>(speed.size()) - 1.001);
    const auto i = static_cast<std::size_t>(grid);
    const double u = grid - static_cast<double>(i);
    by_time.push_back((1.0 - u) * speed[i] + u * speed[i + 1]);
    s += kTimeStep * by_time.back();
    if (next_stop < options.stops_m.size() && s >= options.stops_m[next_stop] - options.begin_m) {
      by_time.insert(by_time.end(), static_cast<std::size_t>(halts_s[next_stop] / kTimeStep), 0.0);
      ++next_stop;
    }
  }
  return by_time;
}

std::vector<double> Smooth(const std::vector<double>& values) {
  std::vector<double> smooth;
  double sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += values[i];
    if (i >= 2 * kSmoothing) {
      // Taking away what was added leaves rounding errors; a halt must not roll back.
      smooth.push_back(std::max(0.0, sum / static_cast<double>(2 * kSmoothing + 1)));
      sum -= values[i - 2 * kSmoothing];
    }
  }
  return smooth;
}

}  // namespace

SpeedProfile SpeedProfile::Constant(double begin_m, double speed_mps) {
  SpeedProfile profile;
  profile.s_m_ = {begin_m};
  profile.speed_mps_ = {speed_mps};
  return profile;
}

SpeedProfile::State SpeedProfile::At(double t_s) const {
  const double last = static_cast<double>(speed_mps_.size() - 1);
  const double steps = t_s / kTimeStep;
  if (steps < 0.0) return {s_m_.front() + t_s * speed_mps_.front(), speed_mps_.front()};
  if (steps >= last) {
    return {s_m_.back() + (t_s - last * kTimeStep) * speed_mps_.back(), speed_mps_.back()};
  }
  const auto i = static_cast<std::size_t>(steps);
  const double dt = t_s - static_cast<double>(i) * kTimeStep;
  const double acceleration = (speed_mps_[i + 1] - speed_mps_[i]) / kTimeStep;
  return {s_m_[i] + dt * (speed_mps_[i] + 0.5 * acceleration * dt),
          speed_mps_[i] + acceleration * dt};
}

SpeedProfile MakeSpeedProfile(const Path& path, const SpeedProfileOptions& options,
                              Random& random) {
  const SpeedLimits limits(path, options, random);
  std::vector<double> halts_s;
  double standing_s = 0.0;
  for (std::size_t i = 0; i < options.stops_m.size(); ++i) {
    halts_s.push_back(Uniform(random, 2.0, 6.0));
    standing_s += halts_s.back();
  }
  const double length_m = options.end_m - options.begin_m;
  const double moving_s = length_m / options.mean_speed_mps - standing_s;
  const std::vector<double> speed = SpeedsForMean(limits, moving_s, options.mean_speed_mps);

  SpeedProfile profile;
  profile.speed_mps_ = Smooth(SpeedsByTime(speed, options, halts_s));
  profile.s_m_ = {options.begin_m};
  for (std::size_t i = 1; i < profile.speed_mps_.size(); ++i) {
    profile.s_m_.push_back(profile.s_m_.back() +
                           0.5 * kTimeStep * (profile.speed_mps_[i - 1] + profile.speed_mps_[i]));
  }
  const auto end = std::lower_bound(profile.s_m_.begin(), profile.s_m_.end(), options.end_m);
  profile.duration_s_ =
      kTimeStep * static_cast<double>(std::max<std::ptrdiff_t>(1, end - profile.s_m_.begin()) - 1);
  return profile;
}

}  // namespace dcloc::simulation
