#include "server/convert/calibration.h"

namespace dcloc::server::convert {
namespace {

void SetSurveyed(const CalibratedParameter& value, v1::SurveyedValue* message) {
  message->set_correction(value.correction);
  message->set_sigma(value.sigma);
  message->set_prior_sigma(value.prior_sigma);
  message->set_applied(value.applied);
}

}  // namespace

void ToProto(const RadarCalibration& radar, v1::SurveyedRadar* message) {
  message->set_radar_id(radar.described.id);
  message->set_described_beta_s(radar.described.beta_s);
  SetSurveyed(radar.of(CalibrationParameter::kBeta), message->mutable_beta_s());
  SetSurveyed(radar.of(CalibrationParameter::kTimeOffset), message->mutable_time_offset_s());
  SetSurveyed(radar.of(CalibrationParameter::kRangeBias), message->mutable_range_bias_m());
  SetSurveyed(radar.of(CalibrationParameter::kMountYaw), message->mutable_mount_yaw_rad());
}

}  // namespace dcloc::server::convert
