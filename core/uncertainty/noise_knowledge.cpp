#include "core/uncertainty/noise_knowledge.h"

#include <string>

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

// Far beyond any sum over a drive, and far from where products of four overflow.
constexpr double kMaxSum = 1e12;

absl::Status CheckBetween(const std::string& name, double value, double min, double max) {
  if (value >= min && value <= max) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("noise.%s is %g; it must lie in [%g, %g]", name, value, min, max));
}

absl::Status Check(const std::string& name, const NoisePairs& pairs) {
  absl::Status status = CheckBetween(name + ".error", pairs.error, -kMaxSum, kMaxSum);
  status.Update(CheckBetween(name + ".registrations", pairs.registrations, 0.0, kMaxSum));
  status.Update(CheckBetween(name + ".odometry", pairs.odometry, 0.0, kMaxSum));
  status.Update(CheckBetween(name + ".count", pairs.count, 0.0, kMaxSum));
  status.Update(CheckBetween(name + ".prior_count", pairs.prior_count, 0.0, kMaxSum));
  status.Update(CheckBetween(name + ".number", pairs.number, 0.0, kMaxSum));
  return status;
}

absl::Status Check(const std::string& name, const NoisePart& part) {
  constexpr double kMaxRatio = 1e6;
  absl::Status status = Check(name + ".near", part.near);
  status.Update(Check(name + ".far", part.far));
  status.Update(CheckBetween(name + ".odometry_ratio", part.odometry_ratio, 0.0, kMaxRatio));
  status.Update(
      CheckBetween(name + ".registration_ratio", part.registration_ratio, 0.0, kMaxRatio));
  return status;
}

}  // namespace

absl::Status Validate(const NoiseKnowledge& knowledge) {
  absl::Status status = Check("translation", knowledge.translation);
  status.Update(Check("rotation", knowledge.rotation));
  return status;
}

}  // namespace dcloc
