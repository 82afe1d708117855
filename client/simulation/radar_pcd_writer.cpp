#include "client/simulation/radar_pcd_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "absl/strings/str_cat.h"

namespace dcloc {
namespace {

static_assert(std::endian::native == std::endian::little, "PCD files hold little-endian numbers");

constexpr double kStaticGate = 0.6;  // [m/s]

struct Target {
  float x, y, z;
  float rcs;
  float vx, vy, vx_comp, vy_comp;
  std::int8_t dyn_prop;
  std::int8_t x_rms, y_rms, vx_rms, vy_rms;
};

// The ARS408's table: 31 steps from 0.005 to 10, each 1.288 times the one before.
std::int8_t RmsCode(double sigma) {
  const double code = std::ceil(std::log(sigma / 0.005) / std::log(std::pow(2000.0, 1.0 / 30.0)));
  return static_cast<std::int8_t>(std::clamp(code, 0.0, 30.0));
}

Eigen::Vector3d RadarVelocity(const Scan& scan, const RadarModel& radar) {
  if (!scan.ego_velocity) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d velocity_vehicle =
      scan.ego_velocity->linear_mps +
      scan.ego_velocity->angular_radps.cross(radar.T_vehicle_radar.translation_m);
  return radar.T_vehicle_radar.rotation.conjugate() * velocity_vehicle;
}

Target MakeTarget(const Scan& scan, std::size_t row, const RadarModel& radar,
                  const Eigen::Vector3d& radar_velocity) {
  const double range = scan.range_m[row];
  const double azimuth = scan.azimuth_rad[row];
  const double elevation = scan.elevation_rad.empty() ? 0.0 : scan.elevation_rad[row];
  const double rate = scan.range_rate_mps[row];
  const Eigen::Vector3d sight(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  const double compensated = rate + sight.dot(radar_velocity);
  const double across = range * radar.azimuth_sigma_rad;
  const double c = std::cos(azimuth);
  const double s = std::sin(azimuth);
  Target target{};
  target.x = static_cast<float>(range * sight.x());
  target.y = static_cast<float>(range * sight.y());
  target.z = static_cast<float>(range * sight.z());
  target.rcs = scan.rcs_dbsm.empty() ? 0.0F : scan.rcs_dbsm[row];
  target.vx = static_cast<float>(rate * c);
  target.vy = static_cast<float>(rate * s);
  target.vx_comp = static_cast<float>(compensated * c);
  target.vy_comp = static_cast<float>(compensated * s);
  target.dyn_prop = std::abs(compensated) < kStaticGate ? 1 : 0;
  target.x_rms = RmsCode(std::hypot(c * radar.range_sigma_m, s * across));
  target.y_rms = RmsCode(std::hypot(s * radar.range_sigma_m, c * across));
  target.vx_rms = RmsCode(std::max(0.005, std::abs(c) * radar.range_rate_sigma_mps));
  target.vy_rms = RmsCode(std::max(0.005, std::abs(s) * radar.range_rate_sigma_mps));
  return target;
}

Target NoTarget() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  return {kNan, kNan, kNan, kNan, kNan, kNan, kNan, kNan, 0, 0, 0, 0, 0};
}

template <typename Value>
void Append(Value value, std::string& bytes) {
  char raw[sizeof(Value)];
  std::memcpy(raw, &value, sizeof(Value));
  bytes.append(raw, sizeof(Value));
}

void AppendRow(const Target& target, std::int16_t id, bool is_target, std::string& bytes) {
  for (const float value : {target.x, target.y, target.z}) Append(value, bytes);
  Append(target.dyn_prop, bytes);
  Append(id, bytes);
  for (const float value : {target.rcs, target.vx, target.vy, target.vx_comp, target.vy_comp}) {
    Append(value, bytes);
  }
  const auto is_quality_valid = static_cast<std::int8_t>(is_target ? 1 : 0);
  const auto ambig_state = static_cast<std::int8_t>(is_target ? 3 : 0);  // unambiguous
  const std::int8_t invalid_state = 0;                                   // valid
  const auto pdh0 = static_cast<std::int8_t>(is_target ? 1 : 0);         // false alarms below 25 %
  for (const std::int8_t code : {is_quality_valid, ambig_state, target.x_rms, target.y_rms,
                                 invalid_state, pdh0, target.vx_rms, target.vy_rms}) {
    Append(code, bytes);
  }
}

std::string Header(std::size_t count) {
  return absl::StrCat(
      "# .PCD v0.7 - Point Cloud Data file format\n"
      "VERSION 0.7\n"
      "FIELDS x y z dyn_prop id rcs vx vy vx_comp vy_comp is_quality_valid ambig_state x_rms y_rms "
      "invalid_state pdh0 vx_rms vy_rms\n"
      "SIZE 4 4 4 1 2 4 4 4 4 4 1 1 1 1 1 1 1 1\n"
      "TYPE F F F I I F F F F F I I I I I I I I\n"
      "COUNT 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\n"
      "WIDTH ",
      count, "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ", count, "\nDATA binary\n");
}

}  // namespace

std::string EncodeRadarPcd(const Scan& scan, const RadarModel& radar) {
  std::string bytes = Header(std::max<std::size_t>(1, scan.size()));
  const Eigen::Vector3d radar_velocity = RadarVelocity(scan, radar);
  for (std::size_t row = 0; row < scan.size(); ++row) {
    AppendRow(MakeTarget(scan, row, radar, radar_velocity), static_cast<std::int16_t>(row), true,
              bytes);
  }
  if (scan.size() == 0) AppendRow(NoTarget(), 0, false, bytes);
  // The devkit insists on at least one byte after the last row.
  bytes += '\n';
  return bytes;
}

}  // namespace dcloc
