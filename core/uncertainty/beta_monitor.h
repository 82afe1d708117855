#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/options/option_fields.h"
#include "core/radar/ego_velocity.h"
#include "core/radar/radar_model.h"
#include "core/radar/stamp.h"
#include "core/registration/correspondences.h"
#include "core/submap/submap.h"

namespace dcloc {

/// The estimated error of a radar's `beta_s`, from registrations.
struct BetaCheck {
  double error_s = 0.0;  ///< to be added to `beta_s`; in dense maps only a part of the actual error
  double sigma_s = 0.0;  ///< deviation of `error_s`
  bool is_wrong = false;  ///< the error is more than chance and geometry explain
};

/// Which inliers the monitor uses, and when it reports a wrong beta.
struct BetaMonitorOptions {
  double forgetting_factor = 0.98;  ///< weight kept of older registrations: about fifty count
  double reuse = 4.0;         ///< registrations that see the same landmarks, so not independent
  double min_range_m = 15.0;  ///< nearer by, heights of scatterers look like beta
  double huber_sigmas = 1.5;
  int min_inlier_count = 30;  ///< of a radar in a registration
  double prior_sigma_s = 0.05;
  double min_range_bias_sigma_m = 0.02;
  /// Error of beta that heights and false correspondences cause, however long it is monitored.
  double sigma_floor_s = 0.006;
  double wrong_sigmas = 3.0;  ///< a larger error is called wrong
};
std::span<const OptionField<BetaMonitorOptions>> FieldsOf(const BetaMonitorOptions& options);
absl::Status Validate(const BetaMonitorOptions& options);

/// Tests whether residuals depend on range rate, as they do if beta is wrong (METHOD 1). Each radar
/// is compared with its own best pose. So errors of its mount and clock, and errors of other
/// radars, do not count. What remains of a wrong beta is that the shift changes with the direction:
/// v cos^2 along the track and v sin cos across. A range bias is estimated with it. The monitor
/// detects errors of hundredths of a second; `Calibrator` finds thousandths. It estimates only a
/// part of the error, because among dense landmarks a shifted point corresponds to a landmark near
/// its shifted position.
template <int Dim>
class BetaMonitor {
 public:
  explicit BetaMonitor(const Rig& rig, const BetaMonitorOptions& options = {});

  /// Whether a registration at `stamp`, whose scans cover `span`, shares no scan with the last one.
  bool IsDue(Stamp stamp, std::chrono::nanoseconds span) const;

  /// An accepted registration of `live` at `T_local_vehicle`, with the correspondences there in the
  /// order of the live points.
  void OnRegistration(Stamp stamp, const LiveSubmap<Dim>& live,
                      std::span<const Correspondence<Dim>> correspondences,
                      const Pose<Dim>& T_local_vehicle, const EgoVelocity& ego_velocity);

  /// The result for a radar, by its index in the rig.
  BetaCheck Check(std::size_t radar_index) const;

 private:
  using Vector = Eigen::Matrix<double, Dim, 1>;
  using Matrix = Eigen::Matrix<double, Dim, Dim>;

  // One radar's correspondences in one registration: normal equations in the pose and in the errors
  // of beta and range bias, in the vehicle frame's axes.
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
             const Eigen::Vector3d& origin_m, const EgoVelocity& ego_velocity, double huber_sigmas);
  };

  // All of one radar's, the poses eliminated.
  struct Radar {
    Eigen::Vector3d origin_m;
    Eigen::Matrix2d known;  // information before the data
    double described_sigma_s;
    Normal normal = {};
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d pull = Eigen::Vector2d::Zero();

    void TakeNormal(const BetaMonitorOptions& options);
  };

  BetaMonitorOptions options_;
  std::vector<Radar> radars_;
  std::optional<Stamp> last_;
};

}  // namespace dcloc
