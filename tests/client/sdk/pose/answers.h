#pragma once

#include <cmath>
#include <cstdint>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

inline constexpr std::int64_t kStart_ns = 1'700'000'000'000'000'000;
inline constexpr std::int64_t kMillisecond_ns = 1'000'000;

inline std::int64_t At(std::int64_t milliseconds) {
  return kStart_ns + milliseconds * kMillisecond_ns;
}

/// A tracked answer at a place in the plane, 0.1 m and 0.01 rad sure.
inline v1::LocalizationResult AnswerAt(std::int64_t milliseconds, double x, double y = 0.0,
                                       double yaw_rad = 0.0) {
  v1::LocalizationResult result;
  result.set_stamp_ns(At(milliseconds));
  result.set_state(v1::LOCALIZATION_STATE_TRACKING);
  v1::Pose& pose = *result.mutable_pose()->mutable_pose();
  pose.mutable_translation_m()->set_x(x);
  pose.mutable_translation_m()->set_y(y);
  pose.mutable_rotation()->set_w(std::cos(0.5 * yaw_rad));
  pose.mutable_rotation()->set_z(std::sin(0.5 * yaw_rad));
  for (int i = 0; i < 36; ++i) {
    result.mutable_pose()->add_covariance(i % 7 != 0 ? 0.0 : i < 18 ? 0.01 : 0.0001);
  }
  return result;
}

inline v1::EgoVelocity Driving(double speed_mps, double yaw_rate_radps = 0.0) {
  v1::EgoVelocity velocity;
  velocity.mutable_linear_mps()->set_x(speed_mps);
  velocity.mutable_angular_radps()->set_z(yaw_rate_radps);
  return velocity;
}

}  // namespace dcloc::client
