#include "client/evaluation/perturbation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "client/datasets/files/check_range.h"
#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

std::mt19937_64 Generator(const Perturbation& perturbation, const std::string& drive,
                          std::uint64_t query) {
  std::vector<std::uint32_t> words(drive.begin(), drive.end());
  for (const std::uint64_t value : {perturbation.seed, query}) {
    words.push_back(static_cast<std::uint32_t>(value));
    words.push_back(static_cast<std::uint32_t>(value >> 32));
  }
  std::seed_seq seeds(words.begin(), words.end());
  return std::mt19937_64(seeds);
}

}  // namespace

absl::Status Validate(const Perturbation& perturbation) {
  absl::Status status =
      CheckRange("perturbation.translation_m", perturbation.translation_m, 0.0, 1000.0);
  status.Update(CheckRange("perturbation.rotation_deg", perturbation.rotation_deg, 0.0, 180.0));
  return status;
}

InitialPose Perturb(const Pose3& T_map_vehicle_true, const Perturbation& perturbation,
                    const std::string& drive, std::uint64_t query) {
  std::mt19937_64 generator = Generator(perturbation, drive, query);
  const double direction_rad =
      std::uniform_real_distribution<double>(-std::numbers::pi, std::numbers::pi)(generator);
  const double turn_deg = std::bernoulli_distribution()(generator) ? perturbation.rotation_deg
                                                                   : -perturbation.rotation_deg;

  InitialPose initial{.T_map_vehicle = T_map_vehicle_true, .covariance = Matrix6d::Zero()};
  initial.T_map_vehicle.translation_m.head<2>() +=
      perturbation.translation_m *
      Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad));
  initial.T_map_vehicle.rotation =
      Eigen::AngleAxisd(turn_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()) *
      initial.T_map_vehicle.rotation;

  const double sigma_m = std::max(0.05, perturbation.translation_m / std::numbers::sqrt2);
  const double yaw_sigma_rad = std::max(0.1, perturbation.rotation_deg) * kRadPerDeg;
  const double tilt_sigma_rad = 0.5 * kRadPerDeg;
  Vector6d sigmas;
  sigmas << sigma_m, sigma_m, 0.1, tilt_sigma_rad, tilt_sigma_rad, yaw_sigma_rad;
  initial.covariance = sigmas.cwiseAbs2().asDiagonal();
  return initial;
}

}  // namespace dcloc
