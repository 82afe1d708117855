#include "core/uncertainty/beta_monitor.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/registration/point_jacobians.h"

namespace dcloc {
namespace {

// Information [1/m^2, 1/rad^2, 1/s^2] of directions that no point measures: a solver needs some.
constexpr double kMinInformation = 1e-6;

static_assert(kBetaError == 0 && kRangeBiasError == 1);

double Squared(double value) { return value * value; }

}  // namespace

std::span<const OptionField<BetaMonitorOptions>> FieldsOf(const BetaMonitorOptions& /*options*/) {
  using O = BetaMonitorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"forgetting_factor", &O::forgetting_factor, 0, 1, "only the newest registration counts"},
      {"reuse", &O::reuse, 1e-6, 1e6},
      {"min_range_m", &O::min_range_m, 0, 1000, "all points count"},
      {"huber_sigmas", &O::huber_sigmas, 1e-6, 1000},
      {"min_inlier_count", &O::min_inlier_count, 1, 100'000},
      {"prior_sigma_s", &O::prior_sigma_s, 1e-9, 10},
      {"min_range_bias_sigma_m", &O::min_range_bias_sigma_m, 1e-9, 100},
      {"sigma_floor_s", &O::sigma_floor_s, 0, 10, "the data alone decide"},
      {"wrong_sigmas", &O::wrong_sigmas, 1e-6, 1e6},
  };
  return kFields;
}

absl::Status Validate(const BetaMonitorOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

template <int Dim>
BetaMonitor<Dim>::BetaMonitor(const Rig& rig, const BetaMonitorOptions& options)
    : options_(options) {
  for (const RadarModel& radar : rig.radars) {
    const double bias_sigma_m = std::max(radar.range_bias_sigma_m, options.min_range_bias_sigma_m);
    radars_.push_back(
        {.origin_m = radar.T_vehicle_radar.translation_m,
         .known = Eigen::Vector2d(1.0 / Squared(options.prior_sigma_s), 1.0 / Squared(bias_sigma_m))
                      .asDiagonal(),
         .described_sigma_s = radar.beta_sigma_s});
  }
}

template <int Dim>
bool BetaMonitor<Dim>::IsDue(Stamp stamp, std::chrono::nanoseconds span) const {
  return !last_ || stamp - *last_ > span;
}

template <int Dim>
void BetaMonitor<Dim>::OnRegistration(Stamp stamp, const LiveSubmap<Dim>& live,
                                      std::span<const Correspondence<Dim>> correspondences,
                                      const Pose<Dim>& T_local_vehicle,
                                      const EgoVelocity& ego_velocity) {
  last_ = stamp;
  const Matrix R = T_local_vehicle.Rotation();
  auto pair = correspondences.begin();
  for (const auto& part : live.parts) {
    Radar& radar = radars_[static_cast<std::size_t>(part.radar_index)];
    const Eigen::Vector3d origin_m = part.T_newest_then * radar.origin_m;
    for (std::size_t i = part.begin; i < part.end && pair != correspondences.end(); ++i) {
      const Vector& p_m = live.points[i].mean_m;
      if (pair->p != p_m) continue;
      if ((p_m - origin_m.head<Dim>()).norm() >= options_.min_range_m) {
        radar.normal.Add(p_m, R.transpose() * (pair->q - T_local_vehicle.translation_m) - p_m,
                         R.transpose() * pair->information * R, origin_m, ego_velocity,
                         options_.huber_sigmas);
      }
      ++pair;
    }
  }
  for (Radar& radar : radars_) radar.TakeNormal(options_);
}

template <int Dim>
BetaCheck BetaMonitor<Dim>::Check(std::size_t radar_index) const {
  const Radar& radar = radars_[radar_index];
  const Eigen::Matrix2d covariance = (radar.known + radar.information).inverse();
  BetaCheck check{.error_s = covariance.row(0).dot(radar.pull),
                  .sigma_s = std::sqrt(covariance(0, 0) + Squared(options_.sigma_floor_s))};
  check.is_wrong = std::abs(check.error_s) >
                   options_.wrong_sigmas * std::hypot(check.sigma_s, radar.described_sigma_s);
  return check;
}

template <int Dim>
void BetaMonitor<Dim>::Normal::Add(const Vector& p_m, const Vector& e_m, const Matrix& information,
                                   const Eigen::Vector3d& origin_m, const EgoVelocity& ego_velocity,
                                   double huber_sigmas) {
  const double squared = e_m.dot(information * e_m);
  const double weight = std::min(1.0, huber_sigmas / std::sqrt(squared));
  const Eigen::Matrix<double, Dim, Pose<Dim>::kDof> G = ByPose(p_m);
  const Eigen::Matrix<double, Dim, 2> D =
      ByRadarErrors<Dim>(p_m, origin_m, ego_velocity).template leftCols<2>();
  const Eigen::Matrix<double, Pose<Dim>::kDof, Dim> GW = weight * G.transpose() * information;
  const Eigen::Matrix<double, 2, Dim> DW = weight * D.transpose() * information;
  pose += GW * G;
  cross += GW * D;
  errors += DW * D;
  pose_pull += GW * e_m;
  pull += DW * e_m;
  squared_residuals += weight * squared;
  ++count;
}

template <int Dim>
void BetaMonitor<Dim>::Radar::TakeNormal(const BetaMonitorOptions& options) {
  Normal& n = normal;
  if (n.count >= static_cast<std::size_t>(options.min_inlier_count)) {
    n.pose.diagonal().array() += kMinInformation;
    const Eigen::LDLT<TangentMatrix<Dim>> solver(n.pose);
    const double misfit = n.squared_residuals / (Dim * static_cast<double>(n.count));
    const double worth = 1.0 / (options.reuse * std::max(1.0, misfit));
    information = options.forgetting_factor * information +
                  worth * (n.errors - n.cross.transpose() * solver.solve(n.cross));
    pull = options.forgetting_factor * pull +
           worth * (n.pull - n.cross.transpose() * solver.solve(n.pose_pull));
  }
  normal = {};
}

template class BetaMonitor<2>;
template class BetaMonitor<3>;

}  // namespace dcloc
