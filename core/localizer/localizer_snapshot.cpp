#include "core/localizer/localizer_snapshot.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {
namespace {

absl::Status CheckStamp(const char* name, Stamp stamp, Stamp newest) {
  const Stamp oldest = ScanLimits{}.min_stamp;
  if (stamp >= oldest && stamp <= newest) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "%s is %d ns; it must lie in [%d, %d] ns", name, stamp.time_since_epoch().count(),
      oldest.time_since_epoch().count(), newest.time_since_epoch().count()));
}

// What has happened happened before the newest scan, else a pose would stay confirmed for ever.
absl::Status CheckStamps(const LocalizerSnapshot& snapshot) {
  const TrackingSnapshot& tracking = snapshot.tracking;
  const Stamp newest = snapshot.stamp;
  absl::Status status = CheckStamp("stamp", newest, ScanLimits{}.max_stamp);
  status.Update(
      CheckStamp("tracking.observability_changed", tracking.observability_changed, newest));
  status.Update(CheckStamp("tracking.last_accepted", tracking.last_accepted, newest));
  if (tracking.last_lost_to_outliers) {
    status.Update(
        CheckStamp("tracking.last_lost_to_outliers", *tracking.last_lost_to_outliers, newest));
  }
  return status;
}

absl::Status CheckVelocity(const EgoVelocity& velocity) {
  if (!velocity.covariance) {
    return absl::InvalidArgumentError("velocity.covariance is missing");
  }
  return Validate(velocity);
}

absl::Status CheckResets(const PoseResets& resets) {
  constexpr int kMaxCount = 1'000'000'000;
  if (resets.count < 0 || resets.count > kMaxCount) {
    return absl::InvalidArgumentError(
        absl::StrFormat("resets.count is %d; it must lie in [0, %d]", resets.count, kMaxCount));
  }
  const Pose3& jump = resets.T_before_after;
  if (!jump.translation_m.allFinite() || !(std::abs(jump.rotation.norm() - 1.0) < 1e-3)) {
    return absl::InvalidArgumentError(
        "resets.T_before_after must be finite with a rotation of norm 1");
  }
  return absl::OkStatus();
}

absl::Status CheckClocks(const std::vector<std::chrono::nanoseconds>& clocks_ahead) {
  constexpr std::chrono::hours kMaxAhead(24 * 365);
  if (clocks_ahead.size() > kMaxRadars) {
    return absl::InvalidArgumentError(absl::StrFormat("clocks_ahead has %d radars; the limit is %d",
                                                      clocks_ahead.size(), kMaxRadars));
  }
  for (const std::chrono::nanoseconds ahead : clocks_ahead) {
    if (ahead >= -kMaxAhead && ahead <= kMaxAhead) continue;
    return absl::InvalidArgumentError(
        absl::StrFormat("clocks_ahead has %d ns; the limit is a year", ahead.count()));
  }
  return absl::OkStatus();
}

absl::Status CheckNumbers(const LocalizerSnapshot& snapshot) {
  constexpr double kMaxInnovation = 1e6;
  constexpr double kMaxContradiction_m = 1e6;
  constexpr int kMaxFactors = 1'000'000'000;
  if (!(snapshot.mean_nis >= 0.0 && snapshot.mean_nis <= kMaxInnovation)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "squared_innovation is %g; it must lie in [0, %g]", snapshot.mean_nis, kMaxInnovation));
  }
  if (!(snapshot.contradiction_m >= 0.0 && snapshot.contradiction_m <= kMaxContradiction_m)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("contradiction_m is %g; it must lie in [0, %g]", snapshot.contradiction_m,
                        kMaxContradiction_m));
  }
  if (snapshot.registration_count < 0 || snapshot.registration_count > kMaxFactors) {
    return absl::InvalidArgumentError(
        absl::StrFormat("registration_count is %d; it must lie in [0, %d]",
                        snapshot.registration_count, kMaxFactors));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Validate(const LocalizerSnapshot& snapshot) {
  absl::Status status = CheckStamps(snapshot);
  status.Update(Validate(snapshot.pose));
  status.Update(CheckVelocity(snapshot.velocity));
  status.Update(Validate(snapshot.tracking));
  status.Update(Validate(snapshot.known));
  status.Update(Validate(snapshot.noise));
  status.Update(CheckResets(snapshot.resets));
  status.Update(CheckNumbers(snapshot));
  status.Update(CheckClocks(snapshot.clocks_ahead));
  if (status.ok()) return status;
  return absl::InvalidArgumentError(absl::StrCat("snapshot: ", status.message()));
}

}  // namespace dcloc
