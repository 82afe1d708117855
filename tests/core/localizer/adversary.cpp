#include "tests/core/localizer/adversary.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace dcloc {

Scan Adversary::NextScan() {
  Scan scan = drive_[next_++ % drive_.size()].scan;
  scan.stamp = now_;
  MoveClock();
  if (Once(5)) scan.radar_id = Once(20) ? "nobody" : "second";
  if (Once(12)) scan.ego_velocity.reset();
  if (Once(8)) {
    if (!scan.ego_velocity) scan.ego_velocity = EgoVelocity{};
    Lie(*scan.ego_velocity);
  }
  if (Once(4)) AddTicks(scan);
  if (Once(10)) Spoil(scan);
  if (Once(20)) Flood(scan);
  if (Once(15)) Thin(scan);
  if (Once(25)) scan = previous_;
  previous_ = scan;
  return scan;
}

PositionFix Adversary::NextFix() {
  PositionFix fix{.stamp = now_, .pose = {}};
  if (Once(10)) fix.stamp += std::chrono::milliseconds(Pick(4000) - 2000);
  if (Once(50)) fix.stamp = Stamp(std::chrono::nanoseconds(Pick(1 << 30)));
  const Pose3& T_map_vehicle = drive_[next_ % drive_.size()].T_map_vehicle;
  fix.pose.T_map_vehicle = T_map_vehicle;
  for (int i = 0; i < 3; ++i) {
    if (Once(4)) fix.pose.T_map_vehicle.translation_m(i) += Extreme();
  }
  if (Once(30)) fix.pose.T_map_vehicle.rotation.coeffs().setZero();
  fix.pose.covariance = Matrix6d::Identity();
  if (Once(5)) fix.pose.covariance *= Extreme();
  if (Once(20)) fix.pose.covariance(Pick(6), Pick(6)) = Extreme();
  return fix;
}

double Adversary::Extreme() {
  static constexpr double kValues[] = {0.0,    1e-30,
                                       -1e-30, 1e-6,
                                       -1e-6,  0.5,
                                       -3.0,   30.0,
                                       -150,   150.0,
                                       1e6,    1e30,
                                       -1e30,  std::numeric_limits<double>::quiet_NaN(),
                                       1e300,  -std::numeric_limits<double>::infinity()};
  return kValues[Pick(static_cast<int>(std::size(kValues)))];
}

void Adversary::MoveClock() {
  now_ += std::chrono::milliseconds(Pick(100));
  if (Once(10)) now_ += std::chrono::milliseconds(Pick(700) - 350);
  if (Once(300)) now_ += std::chrono::seconds(Pick(2'000'000) - 1'000'000);
  if (Once(2000)) now_ = Stamp(std::chrono::nanoseconds(Pick(1 << 30)));
}

void Adversary::Lie(EgoVelocity& velocity) {
  for (int i = 0; i < 3; ++i) {
    if (Once(2)) velocity.linear_mps(i) = Extreme();
    if (Once(3)) velocity.angular_radps(i) = Extreme() / 15.0;
  }
  if (Once(2)) velocity.covariance = Matrix6d(std::abs(Extreme()) * Matrix6d::Identity());
}

void Adversary::AddTicks(Scan& scan) {
  for (int ms = -Pick(300); ms < Pick(60); ms += 1 + Pick(30)) {
    scan.ticks.push_back({.after_scan = std::chrono::milliseconds(ms),
                          .speed_mps = Once(50) ? Extreme() : static_cast<double>(Pick(30)),
                          .yaw_rate_radps = Once(50) ? Extreme() : 0.1 * Pick(7) - 0.3});
  }
}

void Adversary::Spoil(Scan& scan) {
  const auto spoil = [&](std::vector<float>& column) {
    if (column.empty() || !Once(3)) return;
    for (int i = 0; i < 5; ++i) {
      column[static_cast<std::size_t>(Pick(static_cast<int>(column.size())))] =
          static_cast<float>(std::clamp(Extreme(), -1e30, 1e30));
    }
  };
  spoil(scan.range_m);
  spoil(scan.range_rate_mps);
  spoil(scan.azimuth_rad);
  const auto sigmas = [&] {
    return std::vector<float>(scan.size(), static_cast<float>(std::clamp(Extreme(), -1e30, 1e30)));
  };
  if (Once(3)) scan.range_sigma_m = sigmas();
  if (Once(3)) scan.azimuth_sigma_rad = sigmas();
  if (Once(3)) scan.range_rate_sigma_mps = sigmas();
  if (Once(9) && !scan.azimuth_rad.empty()) scan.azimuth_rad.pop_back();
}

// Thousands of targets, at one place or anywhere.
void Adversary::Flood(Scan& scan) {
  const bool at_one_place = Once(2);
  for (int i = Pick(3000); i > 0; --i) {
    scan.range_m.push_back(at_one_place ? 12.0F : static_cast<float>(1 + Pick(200)));
    scan.range_rate_mps.push_back(static_cast<float>(Pick(60) - 30));
    scan.azimuth_rad.push_back(at_one_place ? 0.1F : static_cast<float>(Pick(600)) / 100 - 3);
  }
}

void Adversary::Thin(Scan& scan) {
  const auto count = static_cast<std::size_t>(Pick(4));
  for (auto* column : {&scan.range_m, &scan.range_rate_mps, &scan.azimuth_rad}) {
    column->resize(std::min(column->size(), count));
  }
}

}  // namespace dcloc
