#include "core/map/height_fit.h"

#include <Eigen/LU>
#include <algorithm>

namespace dcloc {
namespace {

// Squares of heights beyond 10 m over the radar are noise: its beam does not reach higher.
constexpr double kMaxHeightSquare_m2 = 100.0;

}  // namespace

void HeightFit::Add(const Eigen::Matrix2d& information, const Eigen::Vector2d& slant_per_m,
                    const Eigen::Vector2d& offset_m) {
  by_position_ += information;
  by_both_ += information * slant_per_m;
  by_height_ += slant_per_m.dot(information * slant_per_m);
  position_pull_ += information * offset_m;
  height_pull_ += slant_per_m.dot(information * offset_m);
}

HeightFit::Solution HeightFit::Solve(double prior_information) const {
  const Eigen::Matrix2d position_covariance = by_position_.inverse();
  const Eigen::Vector2d explained = position_covariance * by_both_;
  const double height_square_m2 =
      std::clamp((height_pull_ - position_pull_.dot(explained)) /
                     (by_height_ - by_both_.dot(explained) + prior_information),
                 0.0, kMaxHeightSquare_m2);
  return {.height_square_m2 = height_square_m2,
          .shift_m = position_covariance * (position_pull_ - height_square_m2 * by_both_)};
}

}  // namespace dcloc
