#pragma once

#include <Eigen/Core>

namespace dcloc {

/// Position and height of one scatterer from returns of planar radars, which take its slant range
/// for a range: p_i = q + h^2 d_i + noise (METHOD eq 40). Normal equations of (q, h^2) that are
/// solved in closed form.
class HeightFit {
 public:
  /// One return: `offset_m` from where the scatterer is taken to be, its `information` [1/m^2], and
  /// `slant_per_m`, by how much it moves for each m^2 of h^2 (d_i).
  void Add(const Eigen::Matrix2d& information, const Eigen::Vector2d& slant_per_m,
           const Eigen::Vector2d& offset_m);

  struct Solution {
    double height_square_m2 = 0.0;  ///< [0, 100]
    Eigen::Vector2d shift_m;        ///< of the scatterer from where it was taken to be
  };

  /// `prior_information` [1/m^4] says how well h^2 = 0 is known before. At least one return.
  Solution Solve(double prior_information) const;

 private:
  Eigen::Matrix2d by_position_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d by_both_ = Eigen::Vector2d::Zero();
  double by_height_ = 0.0;
  Eigen::Vector2d position_pull_ = Eigen::Vector2d::Zero();
  double height_pull_ = 0.0;
};

}  // namespace dcloc
