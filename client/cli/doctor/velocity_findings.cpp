#include "client/cli/doctor/velocity_findings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace dcloc::cli {
namespace {

/// A factor by which a quantity is wrong that was read in another unit, or turned.
struct KnownFactor {
  double factor;
  const char* advice;
};

constexpr const char* kTurn = "turn its sign where it is read";
constexpr std::array kOfSpeed = {
    KnownFactor{3.6, "it is in km/h; send metres a second"},
    KnownFactor{2.237, "it is in miles an hour; send metres a second"},
    KnownFactor{1.0 / 3.6, "it was divided by 3.6 twice, or is in metres a second already"},
    KnownFactor{0.0, "nothing is reported while the vehicle drives: is it the right signal?"},
    KnownFactor{-1.0, kTurn}};
constexpr std::array kOfYawRate = {
    KnownFactor{180.0 / std::numbers::pi, "it is in degrees a second; send radians"},
    KnownFactor{std::numbers::pi / 180.0, "it was turned into radians twice"},
    KnownFactor{-1.0, "turn its sign where it is read: counter-clockwise is positive"},
    KnownFactor{0.0, "nothing is reported while the vehicle turns: is it the right signal?"}};

/// A factor is judged as `name`: sound within `tolerated` of 1, and wrong beyond `wrong`.
template <typename Known>
Finding FactorFinding(const char* name, double factor, double tolerated, double wrong,
                      const Known& known) {
  Finding finding{.check = absl::StrCat("velocity: ", name),
                  .result = CheckResult::kOk,
                  .what = absl::StrFormat("%.3g times what the poses tell", factor),
                  .advice = ""};
  const double off = std::abs(factor - 1.0);
  if (off <= tolerated) return finding;
  finding.result = off <= wrong ? CheckResult::kWarning : CheckResult::kFailed;
  finding.advice = off <= wrong ? "give the wheels' true circumference, or leave it to the server, "
                                  "which learns a percent or so"
                                : "look at its unit and its source";
  for (const KnownFactor& other : known) {
    if (std::abs(factor - other.factor) < 0.05 * std::max(1.0, std::abs(other.factor))) {
      finding.advice = other.advice;
    }
  }
  return finding;
}

Finding ScansFinding(const VelocityCheck& check) {
  constexpr double kUsualShare = 0.9;
  Finding finding{
      .check = "velocity: scans",
      .result = CheckResult::kOk,
      .what = absl::StrFormat("%d of %d scans have one", check.velocity_count, check.scan_count),
      .advice = ""};
  if (check.velocity_count == 0) {
    finding.result = CheckResult::kSkipped;
    finding.advice = "give the wheels' speed and the gyroscope's yaw rate, where there are any";
  } else if (static_cast<double>(check.velocity_count) <
             kUsualShare * static_cast<double>(check.scan_count)) {
    finding.result = CheckResult::kWarning;
    finding.advice = "are velocities stamped by the clock of the radars, and recorded throughout?";
  }
  return finding;
}

Finding DelayFinding(double delay_s) {
  constexpr double kTolerated_s = 0.05;
  Finding finding{.check = "velocity: stamps",
                  .result = CheckResult::kOk,
                  .what = absl::StrFormat("%.0f ms later than the poses", 1e3 * delay_s),
                  .advice = ""};
  if (std::abs(delay_s) <= kTolerated_s) return finding;
  finding.result = CheckResult::kWarning;
  finding.advice = "stamp velocities when they are measured, by the clock of the radars";
  return finding;
}

}  // namespace

Findings VelocityFindings(const VelocityCheck& check) {
  Findings findings = {ScansFinding(check)};
  if (check.speed_factor) {
    findings.push_back(FactorFinding("speed", *check.speed_factor, 0.03, 0.1, kOfSpeed));
  }
  if (check.yaw_rate_factor) {
    findings.push_back(FactorFinding("yaw rate", *check.yaw_rate_factor, 0.1, 0.5, kOfYawRate));
  }
  if (check.delay_s) findings.push_back(DelayFinding(*check.delay_s));
  return findings;
}

}  // namespace dcloc::cli
