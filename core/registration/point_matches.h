#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/local_map.h"

namespace dcloc {

/// A live point with its landmark, and the information of their difference.
template <int Dim>
struct PointMatch {
  Eigen::Matrix<double, Dim, 1> p;  ///< live, vehicle frame
  Eigen::Matrix<double, Dim, 1> q;  ///< landmark, local frame
  Eigen::Matrix<double, Dim, Dim> information;
};

/// Which landmarks may be a live point's match.
struct MatchGates {
  double reach_m = 2.5;      ///< none further away
  double gate_sigmas = 3.5;  ///< nor further in units of the joint deviation
};

/// Finds the landmark of highest likelihood for each live point, again and again as the pose moves.
/// Which landmarks can pass the gates is looked up for a whole neighbourhood of poses at once, and
/// anew only when the pose leaves it: the matches are as if it were looked up every time.
/// Keeps its memory from one sub-map to the next.
template <int Dim>
class MatchFinder {
 public:
  /// What follows is about these; both outlive it.
  void Begin(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
             const MatchGates& gates);

  /// The matches at `T_local_vehicle`, in the order of the live points; `blur_m` is a deviation
  /// added to every pair's. Valid until the next call.
  std::span<const PointMatch<Dim>> Find(const Pose<Dim>& T_local_vehicle, double blur_m);

 private:
  // The poses that the candidates are for.
  struct Neighbourhood {
    Pose<Dim> T_local_vehicle;
    double blur_m;
  };

  bool Covers(const Pose<Dim>& T_local_vehicle, double blur_m) const;
  void LookUp(const Pose<Dim>& T_local_vehicle, double blur_m);

  std::span<const GaussianPoint<Dim>> live_;
  const LocalMap<Dim>* map_ = nullptr;
  MatchGates gates_;
  std::optional<Neighbourhood> neighbourhood_;
  std::vector<std::uint32_t> candidates_;      // indices of landmarks, by live point
  std::vector<std::uint32_t> candidates_end_;  // of each live point
  std::vector<PointMatch<Dim>> matches_;
};

}  // namespace dcloc
