#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/local_map.h"

namespace dcloc {

/// How near each place of a local map's plane is to a landmark: exp(-d^2 / 2 sigma^2) of the
/// nearest one, on a grid. Cheap to look up, so that thousands of poses can be scored.
class LikelihoodField {
 public:
  LikelihoodField() = default;

  /// Cells of `cell_m`, sigma of 1.4 cells.
  template <int Dim>
  LikelihoodField(const LocalMap<Dim>& map, double cell_m);

  /// Mean likelihood of `points` (vehicle xy) at `T_local_vehicle`, in [0, 1].
  double Score(std::span<const Eigen::Vector2f> points, const Pose2& T_local_vehicle) const;

  bool empty() const { return cells_.empty(); }
  double cell_m() const { return cell_m_; }

 private:
  double cell_m_ = 1.0;
  Eigen::Vector2d min_m_ = Eigen::Vector2d::Zero();
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::uint8_t> cells_;  // 255 is a landmark
};

/// The part of the pose space to search, around a centre.
struct SearchWindow {
  Pose2 centre_local_vehicle;
  double translation_m = 1.0;  ///< half-width in x and in y
  double rotation_rad = 0.1;   ///< half-width; pi is every heading
};

/// One candidate pose with its likelihood score.
struct PoseHypothesis {
  Pose2 T_local_vehicle;
  double score = 0.0;
};

/// Up to `max_count` best poses of `points` (vehicle xy) in the window, best first, no two within a
/// grid step of one another (METHOD 5: correlative search). Exhaustive at a step of one grid cell
/// and of the angle that moves the farthest points by about two.
std::vector<PoseHypothesis> CorrelativeSearch(std::span<const Eigen::Vector2f> points,
                                              const LikelihoodField& field,
                                              const SearchWindow& window, int max_count);

}  // namespace dcloc
