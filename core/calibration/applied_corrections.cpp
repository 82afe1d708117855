#include "core/calibration/applied_corrections.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/chi_square.h"

namespace dcloc {
namespace {

bool IsWorthApplying(double square, double variance, double prior_sigma, bool poses_are_own) {
  constexpr double kSquare95 = kSigmas95 * kSigmas95;
  const bool is_determined = variance < 0.25 * prior_sigma * prior_sigma;
  return square > (is_determined && !poses_are_own ? 2.0 : kSquare95) * variance;
}

void ChooseAppliedOf(std::size_t kind, bool poses_are_own, Calibration& calibration) {
  std::vector<RadarCalibration>& radars = calibration.radars;
  const auto count = static_cast<Eigen::Index>(radars.size());
  const auto every =
      Eigen::seqN(static_cast<Eigen::Index>(kind), count, Eigen::fix<kCalibrationParameters>);
  const Eigen::MatrixXd covariance = calibration.covariance(every, every);
  Eigen::VectorXd corrections(count);
  for (Eigen::Index r = 0; r < count; ++r) {
    corrections(r) = radars[static_cast<std::size_t>(r)].parameters.at(kind).correction;
  }
  const double mean = corrections.mean();
  const Eigen::VectorXd own = corrections.array() - mean;
  const double mean_variance = covariance.mean();
  const double own_variance = covariance.diagonal().mean() - mean_variance;
  const double prior_sigma = radars.front().parameters.at(kind).prior_sigma;

  const bool is_in_poses =
      poses_are_own && static_cast<CalibrationParameter>(kind) == CalibrationParameter::kTimeOffset;
  const bool takes_mean =
      !is_in_poses && IsWorthApplying(mean * mean, mean_variance, prior_sigma, poses_are_own);
  const bool takes_own = IsWorthApplying(own.squaredNorm() / static_cast<double>(count),
                                         own_variance, prior_sigma, poses_are_own);
  for (Eigen::Index r = 0; r < count; ++r) {
    CalibratedParameter& value = radars[static_cast<std::size_t>(r)].parameters.at(kind);
    if (takes_mean && takes_own) {
      value.applied = value.correction;
    } else {
      value.applied = (takes_mean ? mean : 0.0) + (takes_own ? own(r) : 0.0);
    }
    value.remaining_sigma =
        std::min(value.prior_sigma, std::hypot(value.sigma, value.correction - value.applied));
  }
}

}  // namespace

void ChooseApplied(Calibration& calibration, bool poses_are_own) {
  for (std::size_t kind = 0; kind < kCalibrationParameters; ++kind) {
    ChooseAppliedOf(kind, poses_are_own, calibration);
  }
}

}  // namespace dcloc
