#pragma once

namespace dcloc {

/// Quantiles of the chi-square distribution: a squared Mahalanobis distance of that many degrees of
/// freedom exceeds them with a probability of 5 % or 0.1 %, where its covariance is right. They are
/// the bounds of gates, rounded to what gates need.
inline constexpr double kChiSquare95With3Dof = 7.815;
inline constexpr double kChiSquare95With6Dof = 12.592;
inline constexpr double kChiSquare999With1Dof = 10.8;
inline constexpr double kChiSquare999With2Dof = 13.8;
inline constexpr double kChiSquare999With3Dof = 16.27;

/// A normally distributed error lies within so many deviations with a probability of 95 %.
inline constexpr double kSigmas95 = 1.96;

}  // namespace dcloc
