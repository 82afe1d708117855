// How a view fits at a place, and when two places are one.
#include <Eigen/Cholesky>
#include <cmath>

#include "core/relocalization/global_localizer.h"

namespace dcloc {

template <int Dim>
typename GlobalLocalizer<Dim>::ViewFit GlobalLocalizer<Dim>::FitAfterMotion(
    const View<Dim>& view, const ViewFit& neighbour, const Motion& motion,
    RegistrationWorkspace<Dim>& workspace) {
  const Pose3 T_map_expected = neighbour.T_map_vehicle * motion.T_from_to;
  ViewFit fit = FitAround(view, T_map_expected, workspace);
  const PoseEstimate<Dim> difference =
      FromSpace<Dim>(T_map_expected.Inverse() * fit.T_map_vehicle, motion.covariance);
  fit.log_likelihood -= 0.5 * SquaredDistance(difference.pose, difference.covariance);
  return fit;
}

// METHOD eq 38.
template <int Dim>
typename GlobalLocalizer<Dim>::ViewFit GlobalLocalizer<Dim>::FitAround(
    const View<Dim>& view, const Pose3& T_map_vehicle, RegistrationWorkspace<Dim>& workspace) {
  const auto found = registrar_.Register(
      view.fine_points, T_map_vehicle, options_.registration_sigma_m, kComparingEffort, workspace);
  if (!found) return {.T_map_vehicle = T_map_vehicle};
  work_ += found->work;
  RegistrationGate gate = options_.gate;
  gate.min_overlap = options_.view_overlap_share * options_.gate.min_overlap;
  const bool is_close = gate.Accepts(found->registration) &&
                        found->registration.overlap >= options_.convincing_overlap;
  return {.T_map_vehicle = found->T_map_vehicle,
          .log_likelihood = options_.log_likelihood_per_score * found->registration.score,
          .is_acceptable = gate.Accepts(found->registration),
          .is_plausible = options_.expected_gate.Accepts(found->registration),
          .is_close = is_close,
          .is_convincing = is_close && found->registration.score >= min_convincing_score_,
          .is_as_usual =
              min_convincing_score_ > 0.0 && found->registration.score >= min_convincing_score_};
}

// Of a registered pose from the one that odometry expects, in units of what both are off by.
template <int Dim>
double GlobalLocalizer<Dim>::SquaredDistance(const Pose<Dim>& difference,
                                             const TangentMatrix<Dim>& odometry) const {
  TangentMatrix<Dim> covariance = odometry;
  covariance.diagonal().template head<Dim>().array() +=
      options_.registration_sigma_m * options_.registration_sigma_m;
  covariance.diagonal().template tail<Pose<Dim>::kDof - Dim>().array() +=
      options_.registration_sigma_rad * options_.registration_sigma_rad;
  const Tangent<Dim> error = Log(difference);
  return error.dot(covariance.ldlt().solve(error));
}

template <int Dim>
bool GlobalLocalizer<Dim>::IsSamePlace(const Pose3& a, const Pose3& b) const {
  return (a.translation_m - b.translation_m).head<2>().norm() < options_.same_place_m &&
         std::abs(WrapAngle(Yaw(a.rotation) - Yaw(b.rotation))) < options_.same_place_rad;
}

template GlobalLocalizer<2>::ViewFit GlobalLocalizer<2>::FitAfterMotion(const View<2>&,
                                                                        const ViewFit&,
                                                                        const Motion&,
                                                                        RegistrationWorkspace<2>&);
template GlobalLocalizer<3>::ViewFit GlobalLocalizer<3>::FitAfterMotion(const View<3>&,
                                                                        const ViewFit&,
                                                                        const Motion&,
                                                                        RegistrationWorkspace<3>&);
template GlobalLocalizer<2>::ViewFit GlobalLocalizer<2>::FitAround(const View<2>&, const Pose3&,
                                                                   RegistrationWorkspace<2>&);
template GlobalLocalizer<3>::ViewFit GlobalLocalizer<3>::FitAround(const View<3>&, const Pose3&,
                                                                   RegistrationWorkspace<3>&);
template bool GlobalLocalizer<2>::IsSamePlace(const Pose3&, const Pose3&) const;
template bool GlobalLocalizer<3>::IsSamePlace(const Pose3&, const Pose3&) const;

}  // namespace dcloc
