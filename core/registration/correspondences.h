#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/lanes.h"
#include "core/geometry/pose.h"
#include "core/map/local_map.h"

namespace dcloc {

/// A live point and its landmark, with the information matrix of their difference.
template <int Dim>
struct Correspondence {
  Eigen::Matrix<double, Dim, 1> p;  ///< live, vehicle frame
  Eigen::Matrix<double, Dim, 1> q;  ///< landmark, local frame, shifted as its height shifts p
  Eigen::Matrix<double, Dim, Dim> information;
};

/// Which landmarks may be a live point's correspondence.
struct CorrespondenceGates {
  double max_distance_m = 2.5;  ///< none further away
  double gate_sigmas = 3.5;     ///< nor further in units of the joint deviation
};

/// Finds the landmark of highest likelihood for each live point, at a sequence of poses near one
/// another. Results that hold over a neighbourhood of poses are computed once, and again only when
/// the pose leaves it. Over a wide neighbourhood: which landmarks can pass the gates. Over a narrow
/// one: their information matrices, and which of them can be the most likely. The correspondences
/// are the same as those of an exhaustive search at each pose, except that information matrices are
/// not rotated within one milliradian. Keeps its memory from one sub-map to the next.
template <int Dim>
class CorrespondenceFinder {
 public:
  /// Sets the points and the map for the following calls; both outlive these.
  void Begin(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
             const CorrespondenceGates& gates);

  /// The correspondences at `T_local_vehicle`, in the order of the live points; `blur_m` is a
  /// deviation added to every pair's. Valid until the next call.
  std::span<const Correspondence<Dim>> Find(const Pose<Dim>& T_local_vehicle, double blur_m);

 private:
  // Poses around a centre.
  struct Neighbourhood {
    Pose<Dim> T_local_vehicle;
    double blur_m;

    bool Holds(const Pose<Dim>& T, double radius_m, double radius_rad) const;
  };

  // A landmark that may be a live point's correspondence, as seen from the middle of a
  // neighbourhood.
  struct Candidate {
    Eigen::Matrix<double, Dim, 1> q;
    Eigen::Matrix<double, Dim, Dim> information;
    double determinant = 0.0;      // of the joint covariance
    double log_determinant = 0.0;  // its logarithm; 0 where there is no other candidate
  };

  void LookUp(const Pose<Dim>& T_local_vehicle, double blur_m);
  void Weigh(const Pose<Dim>& T_local_vehicle, double blur_m);
  float WeighFor(const GaussianPoint<Dim>& point, std::span<const PackedPoint<Dim>> landmarks,
                 double near_m);
  void Keep(const GaussianPoint<Dim>& point, std::span<const PackedPoint<Dim>> landmarks,
            float max_cost);

  std::span<const GaussianPoint<Dim>> live_;
  const LocalMap<Dim>* map_ = nullptr;
  CorrespondenceGates gates_;

  std::optional<Neighbourhood> wide_;
  std::vector<PackedPoint<Dim>> landmarks_;   // those near, by live point, and spare room
  std::vector<std::uint32_t> landmarks_end_;  // of each live point

  std::optional<Neighbourhood> narrow_;
  std::vector<Lanes> min_costs_;               // of the landmarks near one live point
  std::vector<Candidate> candidates_;          // by live point
  std::vector<std::uint32_t> candidates_end_;  // of each live point

  std::vector<Correspondence<Dim>> matches_;
};

}  // namespace dcloc
