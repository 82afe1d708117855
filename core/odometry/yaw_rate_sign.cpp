#include "core/odometry/yaw_rate_sign.h"

#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

// The time constant with which moments lose weight: a curve begins within a second.
constexpr double kTimeConstant_s = 3.0;
// Noise of Doppler's yaw rate, at least: side slip and the mounts' own errors last.
constexpr double kMinSigma_radps = 0.04;
// The sign is certain by so many deviations, of as many moments.
constexpr double kCertainSigmas = 5.0;
constexpr double kMinCount = 4.0;
// A gyroscope of the other sign turns as fast. Of a mount that is knocked in a curve this is
// seldom true.
constexpr double kMaxScaleError = 0.4;

}  // namespace

bool YawRateSign::OnYawRates(Stamp stamp, double speed_mps, double reported_radps,
                             double doppler_radps) {
  const double age_s = last_ ? SecondsOf(stamp - *last_) : 0.0;
  last_ = stamp;
  const double kept = std::exp(-age_s / kTimeConstant_s);
  const auto add = [kept](double& sum, double value) { sum = kept * sum + value; };
  add(sums_.ww, reported_radps * reported_radps);
  add(sums_.wv, reported_radps * speed_mps);
  add(sums_.vv, speed_mps * speed_mps);
  add(sums_.dw, doppler_radps * reported_radps);
  add(sums_.dv, doppler_radps * speed_mps);
  add(sums_.dd, doppler_radps * doppler_radps);
  add(sums_.count, 1.0);
  turn_rad_ = kept * turn_rad_ + age_s * reported_radps;
  if (!IsOpposite()) return false;
  is_reversed_ = !is_reversed_;
  sums_ = {};
  return true;
}

bool YawRateSign::IsOpposite() const {
  const double determinant = sums_.ww * sums_.vv - sums_.wv * sums_.wv;
  if (sums_.count < kMinCount || determinant <= 0.0) return false;
  const double a = (sums_.dw * sums_.vv - sums_.dv * sums_.wv) / determinant;
  const double b = (sums_.dv * sums_.ww - sums_.dw * sums_.wv) / determinant;
  const double square = (sums_.dd - a * sums_.dw - b * sums_.dv) / sums_.count;
  const double sigma_a =
      std::sqrt(std::max(square, kMinSigma_radps * kMinSigma_radps) * sums_.vv / determinant);
  return a + kCertainSigmas * sigma_a < 0.0 && std::abs(a + 1.0) <= kMaxScaleError;
}

}  // namespace dcloc
