#include "client/cli/doctor/rig_checks.h"

#include <array>
#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/progress.h"
#include "client/cli/doctor/velocity_findings.h"
#include "client/datasets/check/range_rate_check.h"
#include "client/datasets/check/scan_statistics.h"
#include "client/datasets/check/velocity_check.h"
#include "client/datasets/drive_calibration.h"
#include "core/geometry/chi_square.h"
#include "core/geometry/degrees.h"

namespace dcloc::cli {
namespace {

/// A parameter of the calibration, and from where on its error matters.
struct Judged {
  CalibrationParameter parameter;
  const char* name;
  const char* unit;
  double per_unit;   ///< of the unit that is printed, in the parameter's own
  double tolerated;  ///< as printed
};

constexpr std::array kJudged = {
    Judged{CalibrationParameter::kBeta, "beta", "s", 1.0, 0.005},
    Judged{CalibrationParameter::kTimeOffset, "stamps", "ms", 1e-3, 10.0},
    Judged{CalibrationParameter::kRangeBias, "range", "m", 1.0, 0.15},
    Judged{CalibrationParameter::kMountYaw, "mount's yaw", "deg", kRadPerDeg, 1.0},
};

constexpr double kSurely = 4.0;  ///< sigmas; four parameters of each radar are looked at
/// A parameter whose interval is wider, in what is tolerated, is not known well enough to be right.
constexpr double kWidestInterval = 2.0;

Finding RangeRateFinding(const RangeRateCheck& check) {
  Finding finding{.check = absl::StrCat("radar ", check.radar_id, ": range rates"),
                  .result = CheckResult::kFailed,
                  .what = MeaningText(check),
                  .advice = ""};
  if (check.target_count > 0) {
    absl::StrAppendFormat(&finding.what, " (%.0f %% of %d targets)", 100.0 * check.best_share,
                          check.target_count);
  }
  using enum RangeRateMeaning;
  switch (check.meaning) {
    case kAway:
      finding.result = CheckResult::kOk;
      break;
    case kUnknown:
      finding.result = CheckResult::kSkipped;
      finding.advice = "take a part of the drive that is faster than 2 m/s";
      break;
    case kTowards:
      finding.advice = "turn the sign of range rates where scans are made";
      break;
    case kCompensated:
      finding.advice = "send range rates as they were measured, without the vehicle's motion out";
      break;
    case kAwayMirrored:
      finding.advice = "turn the sign of azimuths: counter-clockwise from the radar's x axis";
      break;
    case kTowardsMirrored:
      finding.advice = "turn the signs of range rates and of azimuths";
      break;
    case kOfAnotherMount:
      finding.advice = absl::StrCat("swap the mounts, or the ids, of ", check.radar_id, " and ",
                                    check.better_mount);
      break;
    case kNothingFits:
      finding.advice = "compare the mount's yaw with the vehicle; check the clock of velocities";
      break;
  }
  return finding;
}

Finding ScanFinding(const ScanStatistics& radar) {
  constexpr double kGapOfIntervals = 5.0;
  // Radians that were turned into radians once more span less, and no radar sees less.
  constexpr double kNarrowestView_rad = 5.0 * kRadPerDeg;
  constexpr std::size_t kTellingTargets = 200;
  Finding finding{.check = absl::StrCat("radar ", radar.radar_id, ": scans"),
                  .result = CheckResult::kOk,
                  .what = absl::StrFormat("%d scans, %.1f Hz, longest gap %.2f s", radar.scan_count,
                                          radar.Rate_hz(), radar.longest_gap_s),
                  .advice = ""};
  if (radar.target_count == 0) {
    finding.result = CheckResult::kFailed;
    finding.advice = "no targets at all: is the radar on, and are its targets not filtered away?";
  } else if (radar.target_count >= kTellingTargets && radar.azimuth_span_rad < kNarrowestView_rad) {
    finding.result = CheckResult::kFailed;
    absl::StrAppendFormat(&finding.what, "; all azimuths lie within %.1f deg",
                          radar.azimuth_span_rad / kRadPerDeg);
    finding.advice = "are angles in radians read as degrees?";
  } else if (radar.longest_gap_s > kGapOfIntervals * radar.median_interval_s) {
    finding.result = CheckResult::kWarning;
    finding.advice = "scans are missing: look for drops on the bus or in the recorder";
  }
  return finding;
}

/// What the drive cannot tell from a radar's parameter; empty where it can.
std::string ConfusedWith(const Calibration& calibration, const std::string& radar_id,
                         CalibrationParameter parameter) {
  for (const Confusion& confusion : calibration.Confusions()) {
    const bool is_first = confusion.radar == radar_id && confusion.parameter == parameter;
    const bool is_other =
        confusion.other_radar == radar_id && confusion.other_parameter == parameter;
    if (is_first) return NameOf(confusion.other_parameter);
    if (is_other) return NameOf(confusion.parameter);
  }
  return "";
}

Finding CorrectionFinding(const Calibration& calibration, const RadarCalibration& radar,
                          const Judged& judged) {
  const std::string confused = ConfusedWith(calibration, radar.described.id, judged.parameter);
  const CalibratedParameter& parameter = radar.of(judged.parameter);
  const double correction = parameter.correction / judged.per_unit;
  const double interval = kSigmas95 * parameter.sigma / judged.per_unit;
  Finding finding{
      .check = absl::StrCat("radar ", radar.described.id, ": ", judged.name),
      .result = CheckResult::kOk,
      .what = absl::StrFormat("off by %.4g +- %.2g %s", correction, interval, judged.unit),
      .advice = ""};
  if (!parameter.determined()) {
    finding.result = CheckResult::kSkipped;
    absl::StrAppend(&finding.what, ": the drive does not tell");
  } else if (!confused.empty()) {
    finding.result = CheckResult::kSkipped;
    absl::StrAppend(&finding.what, ": the drive does not tell it from ", confused);
  } else if (const bool is_off = std::abs(correction) > judged.tolerated;
             is_off && std::abs(correction) > kSurely * parameter.sigma / judged.per_unit) {
    finding.result = CheckResult::kWarning;
    finding.advice = "make a rig file by `dcloc calibrate` of several drives, and give it as --rig";
  } else if (is_off || interval > kWidestInterval * judged.tolerated) {
    finding.result = CheckResult::kSkipped;
    absl::StrAppend(&finding.what, ": the drive does not tell well enough");
    finding.advice = "take a longer one, with bends and other speeds";
  }
  return finding;
}

/// Its range rates are then held against its poses.
Drive WithoutVelocities(Drive drive) {
  for (DriveScan& entry : drive.scans) entry.scan.ego_velocity.reset();
  return drive;
}

void AddCalibration(const Drive& drive, Findings& findings) {
  const auto skip = [&](absl::string_view why) {
    findings.push_back({"calibration", CheckResult::kSkipped, std::string(why), ""});
  };
  if (drive.pose_source != PoseSource::kReference) {
    return skip("beta, stamps and mounts need a drive with reference poses");
  }
  absl::StatusOr<Calibrator> calibrator = Calibrator::Create(drive.rig);
  absl::Status status = calibrator.status();
  if (status.ok()) status = AddDrive(drive, *calibrator);
  if (!status.ok()) return skip(status.message());
  std::optional<Progress> progress;
  const auto calibration = calibrator->Estimate([&](std::size_t done, std::size_t total) {
    if (!progress) progress.emplace("calibrating", total);
    progress->Update(done);
  });
  progress.reset();
  if (!calibration.ok()) return skip(calibration.status().message());
  for (const RadarCalibration& radar : calibration->radars) {
    for (const Judged& judged : kJudged)
      findings.push_back(CorrectionFinding(*calibration, radar, judged));
  }
}

}  // namespace

Findings CheckRig(const Drive& drive) {
  Findings findings;
  for (const ScanStatistics& radar : ScanStatisticsOf(drive)) {
    findings.push_back(ScanFinding(radar));
  }
  const Findings of_velocity = VelocityFindings(CheckVelocities(drive));
  findings.insert(findings.end(), of_velocity.begin(), of_velocity.end());
  const bool has_velocity = WorstOf(of_velocity) != CheckResult::kFailed;
  bool is_sound = has_velocity;
  for (const RangeRateCheck& check :
       CheckRangeRates(has_velocity ? drive : WithoutVelocities(drive))) {
    findings.push_back(RangeRateFinding(check));
    is_sound = is_sound && findings.back().result != CheckResult::kFailed;
  }
  if (is_sound) {
    AddCalibration(drive, findings);
  } else {
    findings.push_back(
        {"calibration", CheckResult::kSkipped,
         "beta, stamps and mounts are told once velocities and range rates are right", ""});
  }
  return findings;
}

}  // namespace dcloc::cli
