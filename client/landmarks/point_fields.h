#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "core/map/radar_map.h"

namespace dcloc {

/// What files call the values of a landmark, other than its position in the map. Positions and
/// covariances are in its keyframe's frame.
struct PointField {
  const char* name;
  float MapPoint::*member;
};
inline constexpr std::array kPointFields = {
    PointField{"keyframe_x_m", &MapPoint::x_m}, PointField{"keyframe_y_m", &MapPoint::y_m},
    PointField{"keyframe_z_m", &MapPoint::z_m}, PointField{"xx_m2", &MapPoint::xx_m2},
    PointField{"xy_m2", &MapPoint::xy_m2},      PointField{"xz_m2", &MapPoint::xz_m2},
    PointField{"yy_m2", &MapPoint::yy_m2},      PointField{"yz_m2", &MapPoint::yz_m2},
    PointField{"zz_m2", &MapPoint::zz_m2},      PointField{"rcs_dbsm", &MapPoint::rcs_dbsm}};

struct CountField {
  const char* name;
  std::uint16_t MapPoint::*member;
};
inline constexpr std::array kCountFields = {CountField{"scan_count", &MapPoint::scan_count},
                                            CountField{"pass_count", &MapPoint::pass_count}};

/// InvalidArgument that names the field, the value and the bound.
inline absl::Status SetField(const PointField& field, double value, MapPoint& point) {
  if (!(std::abs(value) <= 3e38)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s is %g; it must be a finite number", field.name, value));
  }
  point.*field.member = static_cast<float>(value);
  return absl::OkStatus();
}

inline absl::Status SetField(const CountField& field, double value, MapPoint& point) {
  if (!(value >= 0.0 && value <= 65535.0) || value != std::floor(value)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s is %g; it must be a whole number in [0, 65535]", field.name, value));
  }
  point.*field.member = static_cast<std::uint16_t>(value);
  return absl::OkStatus();
}

/// The number of a keyframe: a whole number below 2^32.
inline absl::Status CheckKeyframeNumber(double value) {
  if (value >= 0.0 && value <= 4294967295.0 && value == std::floor(value)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("keyframe is %g; it must be a whole number in [0, 2^32 - 1]", value));
}

}  // namespace dcloc
