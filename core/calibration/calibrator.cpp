#include "core/calibration/calibrator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "core/calibration/applied_corrections.h"
#include "core/calibration/gaussian_overlap.h"
#include "core/geometry/thinning.h"

namespace dcloc {
namespace {

absl::Status CheckBound(const char* field, double value, double min, double max) {
  // Written so that NaN fails.
  if (value >= min && value <= max) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %g; it must lie in [%g, %g]", field, value, min, max));
}

// The gradient's spread, made regular where blocks are fewer than parameters.
Eigen::MatrixXd Regular(Eigen::MatrixXd spread) {
  spread.diagonal() *= 1.01;
  spread.diagonal().array() += 1e-9 + 1e-9 * spread.diagonal().maxCoeff();
  return spread;
}

// Parameters and what is known of them, in units of the prior's deviations.
struct Posterior {
  Eigen::VectorXd parameters;
  Eigen::MatrixXd information;

  Eigen::MatrixXd Covariance() const {
    return information.ldlt().solve(
        Eigen::MatrixXd::Identity(information.rows(), information.cols()));
  }
};

// One Gauss-Newton step towards the largest posterior. With the Godambe information
// G = H V^-1 H, the data alone say x + H^-1 g; G (x + H^-1 g) = G x + H V^-1 g needs no inverse
// of H, which is singular where the data say nothing.
Posterior Step(const Posterior& posterior, const OverlapTerms& terms,
               const Eigen::MatrixXd& prior) {
  const Eigen::LDLT<Eigen::MatrixXd> spread(Regular(terms.spread));
  const Eigen::MatrixXd godambe = terms.hessian * spread.solve(terms.hessian);
  const Eigen::VectorXd pull =
      godambe * posterior.parameters + terms.hessian * spread.solve(terms.gradient);
  const Eigen::MatrixXd information = prior + godambe;
  return {.parameters = information.ldlt().solve(pull), .information = information};
}

// Of the corrections in units of their deviations: independent of one another, but for the betas,
// which are one value for all radars and a small one of each radar's own.
Eigen::MatrixXd PriorInformation(Eigen::Index size, const CalibratorOptions& options) {
  const double own = std::min(1.0, std::pow(options.beta_spread_s / options.prior_sigma[0], 2));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(size, size);
  for (Eigen::Index i = 0; i < size; i += kCalibrationParameters) {
    for (Eigen::Index j = 0; j < size; j += kCalibrationParameters) {
      if (i != j) covariance(i, j) = 1.0 - own;
    }
  }
  return covariance.llt().solve(Eigen::MatrixXd::Identity(size, size));
}

// Covariance of what two estimates differ by, which is taken for one error that is common to the
// radars and one of each radar's own, for each kind of parameter.
Eigen::MatrixXd CovarianceOf(const Eigen::VectorXd& difference) {
  const Eigen::Index size = difference.size();
  const auto of_radars = difference.reshaped(kCalibrationParameters, Eigen::AutoSize);
  const Eigen::VectorXd common = of_radars.rowwise().mean();
  const Eigen::VectorXd own_variance =
      (of_radars.colwise() - common).array().square().rowwise().mean();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Eigen::Index kind = i % kCalibrationParameters;
    for (Eigen::Index j = kind; j < size; j += kCalibrationParameters) {
      covariance(i, j) = common(kind) * common(kind);
    }
    covariance(i, i) += own_variance(kind);
  }
  return covariance;
}

struct PairedFrame {
  FrameReturns seen;
  std::vector<ReturnPair> pairs;
};

// `scale` is 0 for what is left alone: beside a narrow prior its gradient would stay in the Godambe
// information and move the others as if it measured them.
Posterior Solve(const std::vector<PairedFrame>& frames, const Eigen::VectorXd& scale,
                const CalibratorOptions& options, double min_range_m,
                const std::function<void()>& on_step) {
  const Eigen::Index size = scale.size();
  const Eigen::MatrixXd prior = PriorInformation(size, options);
  Posterior posterior{.parameters = Eigen::VectorXd::Zero(size), .information = prior};
  for (const double sigma_m : options.scatterer_sigmas_m) {
    for (int i = 0; i < options.iterations_per_sigma; ++i) {
      OverlapTerms terms(size);
      for (const PairedFrame& frame : frames) {
        AddOverlap(
            frame.seen, frame.pairs, posterior.parameters, scale,
            {.scatterer_sigma_m = sigma_m, .block_m = options.block_m, .min_range_m = min_range_m},
            terms);
      }
      posterior = Step(posterior, terms, prior);
      on_step();
    }
  }
  return posterior;
}

Eigen::VectorXd OfEachRadar(const CalibrationVector& values, std::size_t radar_count) {
  return Eigen::Map<const Eigen::Matrix<double, kCalibrationParameters, 1>>(values.data())
      .replicate(static_cast<Eigen::Index>(radar_count), 1);
}

// A share of the returns, evenly among them, with their pairs.
PairedFrame Paired(const FrameReturns& seen, double share, const CalibratorOptions& options) {
  const auto count = static_cast<int>(std::ceil(share * static_cast<double>(seen.returns.size())));
  PairedFrame paired{.seen = {.scans = seen.scans, .returns = EvenSubsample(seen.returns, count)}};
  paired.pairs = FindPairs(paired.seen, options.max_pair_distance_m, options.max_pairs_per_return);
  return paired;
}

// The covariance of the estimate from far returns. What near returns, or a range scale, change in
// it is an error of its own.
Eigen::MatrixXd CovarianceOfFar(const Eigen::VectorXd& scale, const Posterior& far,
                                const Posterior& all, const Posterior& scaled) {
  Eigen::MatrixXd covariance = scale.asDiagonal() * far.Covariance() * scale.asDiagonal();
  covariance += CovarianceOf(scale.cwiseProduct(far.parameters - all.parameters)) +
                CovarianceOf(scale.cwiseProduct(far.parameters - scaled.parameters));
  return covariance;
}

// What was estimated of each radar, as multiples of `scale`, with what is known of it afterwards.
std::vector<RadarCalibration> CalibrationsOf(const Rig& rig, const Eigen::VectorXd& scale,
                                             const Eigen::VectorXd& prior_sigma,
                                             const Eigen::VectorXd& parameters,
                                             const Eigen::MatrixXd& covariance) {
  std::vector<RadarCalibration> calibrations;
  for (std::size_t r = 0; r < rig.radars.size(); ++r) {
    RadarCalibration radar{.described = rig.radars[r], .parameters = {}};
    for (std::size_t k = 0; k < kCalibrationParameters; ++k) {
      const auto at = static_cast<Eigen::Index>(r * kCalibrationParameters + k);
      radar.parameters.at(k) = {.correction = scale(at) * parameters(at),
                                .sigma = std::min(prior_sigma(at), std::sqrt(covariance(at, at))),
                                .prior_sigma = prior_sigma(at)};
    }
    calibrations.push_back(std::move(radar));
  }
  return calibrations;
}

}  // namespace

std::span<const OptionField<CalibratorOptions>> FieldsOf(const CalibratorOptions& /*options*/) {
  using O = CalibratorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"beta_spread_s", &O::beta_spread_s, 1e-6, 1},
      {"far_range_m", &O::far_range_m, 0, 1000, "no return is left out"},
      {"iterations_per_sigma", &O::iterations_per_sigma, 1, 100},
      {"max_pair_distance_m", &O::max_pair_distance_m, 0.1, 10},
      {"max_pairs_per_return", &O::max_pairs_per_return, 1, 10'000},
      {"max_returns", &O::max_returns, 1, 1e9},
      {"stand_distance_m", &O::stand_distance_m, 0, 100, "each pose has errors of its own"},
      {"block_m", &O::block_m, 0.1, 1000},
  };
  return kFields;
}

absl::Status Validate(const CalibratorOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  for (const double sigma : options.prior_sigma) {
    status.Update(CheckBound("prior_sigma", sigma, 0.0, 100.0));
  }
  for (const double sigma : options.floor_sigma) {
    status.Update(CheckBound("floor_sigma", sigma, 0.0, 100.0));
  }
  status.Update(CheckBound("scatterer_sigmas_m: size",
                           static_cast<double>(options.scatterer_sigmas_m.size()), 1, 100));
  for (const double sigma_m : options.scatterer_sigmas_m) {
    status.Update(CheckBound("scatterer_sigmas_m", sigma_m, 0.01, 10.0));
  }
  status.Update(Within("static_points", Validate(options.static_points)));
  return status;
}

absl::StatusOr<Calibrator> Calibrator::Create(Rig rig, CalibratorOptions options) {
  absl::Status status = Validate(rig);
  status.Update(Validate(options));
  if (!status.ok()) return status;
  return Calibrator(std::move(rig), std::move(options));
}

Calibrator::Frame& Calibrator::FrameNamed(const std::string& name,
                                          const Eigen::Vector3d& origin_m) {
  const auto [at, is_new] = frames_.try_emplace(name);
  if (is_new) {
    at->second.origin_m = origin_m;
    at->second.stands.resize(rig_.radars.size());
  }
  return at->second;
}

std::uint32_t Calibrator::StandAt(Frame& frame, const Eigen::Vector2d& position_m,
                                  std::size_t radar) const {
  Stand& stand = frame.stands[radar];
  if ((position_m - stand.position_m).norm() > options_.stand_distance_m) {
    stand = {.position_m = position_m, .number = stand.number + 1};
  }
  return stand.number;
}

absl::Status Calibrator::Add(const std::string& frame_name, const Scan& scan,
                             const Pose3& T_map_vehicle, const EgoVelocity& ego_velocity) {
  absl::Status status = Validate(scan);
  status.Update(Validate(ego_velocity));
  status.Update(
      CheckBound("T_map_vehicle: rotation's norm", T_map_vehicle.rotation.norm(), 0.999, 1.001));
  status.Update(
      CheckBound("T_map_vehicle: translation_m", T_map_vehicle.translation_m.norm(), 0.0, 1e8));
  if (!status.ok()) return status;
  const RadarModel* const radar = rig_.Find(scan.radar_id);
  if (radar == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrFormat("radar_id is \"%s\"; the rig has no such radar", scan.radar_id));
  }
  Frame& frame = FrameNamed(frame_name, T_map_vehicle.translation_m);
  const auto radar_index = static_cast<std::uint32_t>(radar - rig_.radars.data());
  const Eigen::Matrix<double, 2, 3> rotation = T_map_vehicle.Rotation().topRows<2>();
  const Eigen::Vector2d vehicle_m = (T_map_vehicle.translation_m - frame.origin_m).head<2>();
  const Eigen::Vector3d& mount_m = radar->T_vehicle_radar.translation_m;
  const Eigen::Vector3d radar_velocity_mps =
      ego_velocity.linear_mps + ego_velocity.angular_radps.cross(mount_m);
  for (const RadarPoint& point : StaticPoints(scan, *radar, ego_velocity, options_.static_points)) {
    const Eigen::Vector3d sight_m = point.position_m - mount_m;
    frame.seen.returns.push_back(
        {.position_m = vehicle_m + rotation * point.position_m,
         .covariance_m2 = rotation * point.covariance_m2 * rotation.transpose(),
         .range_m = sight_m.norm(),
         .cos_elevation = sight_m.head<2>().norm() / sight_m.norm(),
         .scan = static_cast<std::uint32_t>(frame.seen.scans.size())});
  }
  frame.seen.scans.push_back({.radar_m = vehicle_m + rotation * mount_m,
                              .radar_velocity_mps = rotation * radar_velocity_mps,
                              .vehicle_m = vehicle_m,
                              .vehicle_velocity_mps = rotation * ego_velocity.linear_mps,
                              .yaw_rate_radps = ego_velocity.angular_radps.z(),
                              .planar = !radar->has_elevation,
                              .radar = radar_index,
                              .stand = StandAt(frame, vehicle_m, radar_index)});
  return absl::OkStatus();
}

absl::StatusOr<Calibration> Calibrator::Estimate(const ProgressCallback& progress) const {
  std::size_t total = 0;
  for (const auto& [name, frame] : frames_) total += frame.seen.returns.size();
  const double share =
      std::min(1.0, static_cast<double>(options_.max_returns) / static_cast<double>(total));
  Calibration calibration;
  std::vector<PairedFrame> frames;
  for (const auto& [name, frame] : frames_) {
    const PairedFrame& paired = frames.emplace_back(Paired(frame.seen, share, options_));
    calibration.return_count += paired.seen.returns.size();
    calibration.pair_count += paired.pairs.size();
  }
  if (calibration.pair_count == 0) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "of %d static returns no two lie within %g m of one another that were seen by different "
        "radars or from poses %g m apart",
        total, options_.max_pair_distance_m, options_.stand_distance_m));
  }

  CalibrationVector without_range_scale = options_.prior_sigma;
  without_range_scale.at(static_cast<std::size_t>(CalibrationParameter::kRangeScale)) = 0.0;
  const Eigen::VectorXd scale = OfEachRadar(without_range_scale, rig_.radars.size());
  const Eigen::VectorXd prior_sigma = OfEachRadar(options_.prior_sigma, rig_.radars.size());
  const std::size_t step_count = 3 * options_.scatterer_sigmas_m.size() *
                                 static_cast<std::size_t>(options_.iterations_per_sigma);
  std::size_t done = 0;
  const auto on_step = [&] {
    ++done;
    if (progress) progress(done, step_count);
  };
  const Posterior far = Solve(frames, scale, options_, options_.far_range_m, on_step);
  const Posterior all = Solve(frames, scale, options_, 0.0, on_step);
  const Posterior scaled = Solve(frames, prior_sigma, options_, options_.far_range_m, on_step);
  calibration.covariance = CovarianceOfFar(scale, far, all, scaled);
  calibration.covariance.diagonal() +=
      OfEachRadar(options_.floor_sigma, rig_.radars.size()).cwiseAbs2() +
      (prior_sigma - scale).cwiseAbs2();

  calibration.radars =
      CalibrationsOf(rig_, scale, prior_sigma, far.parameters, calibration.covariance);
  ChooseApplied(calibration);
  return calibration;
}

}  // namespace dcloc
