#include "core/calibration/calibration.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/geometry/chi_square.h"

namespace dcloc {

const char* NameOf(CalibrationParameter parameter) {
  switch (parameter) {
    case CalibrationParameter::kBeta:
      return "beta_s";
    case CalibrationParameter::kTimeOffset:
      return "time_offset_s";
    case CalibrationParameter::kRangeBias:
      return "range_bias_m";
    case CalibrationParameter::kMountYaw:
      return "mount_yaw_rad";
    case CalibrationParameter::kHeightSquare:
      return "height_square_m2";
    case CalibrationParameter::kRangeScale:
      break;
  }
  return "range_scale";
}

bool CalibratedParameter::significant() const {
  return determined() && std::abs(correction) > kSigmas95 * sigma;
}

std::vector<Confusion> Calibration::Confusions() const {
  constexpr double kLimit = 0.9;
  constexpr std::size_t kN = kCalibrationParameters;
  const auto determined = [this](std::size_t i) {
    return radars[i / kN].parameters.at(i % kN).determined();
  };
  std::vector<Confusion> confusions;
  for (std::size_t i = 0; i < radars.size() * kN; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!determined(i) && !determined(j)) continue;
      const auto a = static_cast<Eigen::Index>(j);
      const auto b = static_cast<Eigen::Index>(i);
      const double correlation = covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b));
      if (!(std::abs(correlation) > kLimit)) continue;  // nor where one was left alone, and NaN
      confusions.push_back({.radar = radars[j / kN].described.id,
                            .parameter = static_cast<CalibrationParameter>(j % kN),
                            .other_radar = radars[i / kN].described.id,
                            .other_parameter = static_cast<CalibrationParameter>(i % kN),
                            .correlation = correlation});
    }
  }
  return confusions;
}

RadarModel Corrected(const RadarModel& described, CalibrationParameter parameter,
                     double correction) {
  RadarModel radar = described;
  switch (parameter) {
    case CalibrationParameter::kBeta:
      radar.beta_s += correction;
      break;
    case CalibrationParameter::kTimeOffset:
      radar.time_offset_s += correction;
      break;
    case CalibrationParameter::kRangeBias:
      radar.range_bias_m += correction;
      break;
    case CalibrationParameter::kMountYaw:
      radar.T_vehicle_radar.rotation = (Eigen::AngleAxisd(correction, Eigen::Vector3d::UnitZ()) *
                                        described.T_vehicle_radar.rotation)
                                           .normalized();
      break;
    case CalibrationParameter::kHeightSquare:
    case CalibrationParameter::kRangeScale:
      break;
  }
  return radar;
}

RadarModel Calibrated(const RadarCalibration& radar) {
  RadarModel model = radar.described;
  for (int i = 0; i < kCalibrationParameters; ++i) {
    const auto parameter = static_cast<CalibrationParameter>(i);
    model = Corrected(model, parameter, radar.of(parameter).applied);
  }
  model.beta_sigma_s = radar.of(CalibrationParameter::kBeta).remaining_sigma;
  model.time_offset_sigma_s = radar.of(CalibrationParameter::kTimeOffset).remaining_sigma;
  model.range_bias_sigma_m = radar.of(CalibrationParameter::kRangeBias).remaining_sigma;
  model.mount_yaw_sigma_rad = radar.of(CalibrationParameter::kMountYaw).remaining_sigma;
  return model;
}

}  // namespace dcloc
