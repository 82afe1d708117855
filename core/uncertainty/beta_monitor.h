#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/registration/correspondences.h"
#include "core/submap/submap.h"

namespace dcloc {

/// What registrations say of a radar's `beta_s`.
struct BetaCheck {
  double error_s = 0.0;   ///< to be added to it; in dense maps only a part of what is wrong
  double sigma_s = 0.0;   ///< deviation of that
  bool is_wrong = false;  ///< the error is more than chance and geometry explain
};

/// Watches whether what registrations leave over depends on range rate, which a wrong beta makes it
/// do (METHOD 1). Each radar is held against its own best pose, so that neither its mount and its
/// clock nor what is wrong with other radars count: what is left of a wrong beta is how the shift
/// changes with the direction, v cos^2 along the track and v sin cos across, for which a range bias
/// is freed. It finds an error of hundredths of a second, where `Calibrator` finds thousandths, and
/// less than its whole, because points with landmarks all around match those that they were shifted
/// to.
template <int Dim>
class BetaMonitor {
 public:
  explicit BetaMonitor(const Rig& rig);

  /// Whether a registration at `stamp` of scans over `span` has none of the last one's.
  bool IsDue(Stamp stamp, std::chrono::nanoseconds span) const;

  /// A believed registration of `live` at `T_local_vehicle`, with the matches there in the order of
  /// the live points.
  void OnRegistration(Stamp stamp, const LiveSubmap<Dim>& live,
                      std::span<const Correspondence<Dim>> matches,
                      const Pose<Dim>& T_local_vehicle, const EgoVelocity& ego_velocity);

  /// Of a radar of the rig, by its place there.
  BetaCheck Check(std::size_t radar_index) const;

 private:
  using Vector = Eigen::Matrix<double, Dim, 1>;
  using Matrix = Eigen::Matrix<double, Dim, Dim>;

  // One radar's matches in one registration: normal equations in the pose and in the errors of beta
  // and range bias, in the vehicle frame's axes.
  struct Normal {
    TangentMatrix<Dim> pose = TangentMatrix<Dim>::Zero();
    Eigen::Matrix<double, Pose<Dim>::kDof, 2> cross =
        Eigen::Matrix<double, Pose<Dim>::kDof, 2>::Zero();
    Eigen::Matrix2d errors = Eigen::Matrix2d::Zero();
    Tangent<Dim> pose_pull = Tangent<Dim>::Zero();
    Eigen::Vector2d pull = Eigen::Vector2d::Zero();
    double squared_residuals = 0.0;
    std::size_t count = 0;

    // Of a point at `p_m`, seen from `origin_m`, whose landmark lies `e_m` from it.
    void Add(const Vector& p_m, const Vector& e_m, const Matrix& information,
             const Eigen::Vector3d& origin_m, const EgoVelocity& ego_velocity);
  };

  // All of one radar's, the poses eliminated.
  struct Radar {
    Eigen::Vector3d origin_m;
    Eigen::Matrix2d known;  // information before the data
    double described_sigma_s;
    Normal normal = {};
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d pull = Eigen::Vector2d::Zero();

    void TakeNormal();
  };

  std::vector<Radar> radars_;
  std::optional<Stamp> last_;
};

}  // namespace dcloc
