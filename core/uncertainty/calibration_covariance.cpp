#include "core/uncertainty/calibration_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>

#include "core/geometry/thinning.h"
#include "core/registration/point_jacobians.h"

namespace dcloc {
namespace {

// An even choice of points says it well enough.
constexpr std::size_t kMaxChosenPoints = 256;
// Prior of the pose, for directions of which the points say nothing: far wider than a
// registration's own error, so that it changes nothing where they do.
constexpr double kPriorSigma_m = 1.0;
constexpr double kPriorSigma_rad = 0.1;

Eigen::Vector4d Deviations(const RadarModel& radar) {
  return {radar.beta_sigma_s, radar.range_bias_sigma_m, radar.time_offset_sigma_s,
          radar.mount_yaw_sigma_rad};
}

}  // namespace

template <int Dim>
TangentMatrix<Dim> CalibrationCovariance(const LiveSubmap<Dim>& live, const Rig& rig,
                                         const EgoVelocity& ego_velocity) {  // METHOD eq 35
  constexpr int kDof = Pose<Dim>::kDof;
  using Pull = Eigen::Matrix<double, kDof, kRadarErrors>;
  Tangent<Dim> prior;
  prior.template head<Dim>().setConstant(1.0 / (kPriorSigma_m * kPriorSigma_m));
  prior.template tail<kDof - Dim>().setConstant(1.0 / (kPriorSigma_rad * kPriorSigma_rad));
  TangentMatrix<Dim> information = prior.asDiagonal();
  std::array<Pull, kMaxRadars> pulls;
  std::fill_n(pulls.begin(), rig.radars.size(), Pull::Zero());
  const std::size_t stride = StepToKeep(kMaxChosenPoints, live.points.size());
  for (const auto& part : live.parts) {
    const auto radar_index = static_cast<std::size_t>(part.radar_index);
    const Eigen::Vector3d origin_m =
        part.T_newest_then * rig.radars[radar_index].T_vehicle_radar.translation_m;
    const std::size_t first = (part.begin + stride - 1) / stride * stride;
    for (std::size_t i = first; i < part.end; i += stride) {
      const GaussianPoint<Dim>& point = live.points[i];
      const Eigen::Matrix<double, Dim, kDof> by_pose = ByPose(point.mean_m);
      const Eigen::Matrix<double, kDof, Dim> weighted =
          by_pose.transpose() * point.covariance_m2.inverse();
      information += weighted * by_pose;
      pulls.at(radar_index) += weighted * ByRadarErrors<Dim>(point.mean_m, origin_m, ego_velocity);
    }
  }
  const Eigen::LDLT<TangentMatrix<Dim>> solver(information);
  TangentMatrix<Dim> covariance = TangentMatrix<Dim>::Zero();
  for (std::size_t i = 0; i < rig.radars.size(); ++i) {
    const Pull shifts = solver.solve(pulls.at(i)) * Deviations(rig.radars[i]).asDiagonal();
    covariance += shifts * shifts.transpose();
  }
  return covariance;
}

template TangentMatrix<2> CalibrationCovariance<2>(const LiveSubmap<2>&, const Rig&,
                                                   const EgoVelocity&);
template TangentMatrix<3> CalibrationCovariance<3>(const LiveSubmap<3>&, const Rig&,
                                                   const EgoVelocity&);

}  // namespace dcloc
