#include "client/evaluation/robustness/judgement.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>

#include "client/evaluation/metrics.h"

namespace dcloc::robustness {
namespace {

double Seconds(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

bool IsTracking(const ScanOutcome& scan) {
  return scan.answer.state == LocalizationState::kTracking;
}

bool IsRightTracking(const ScanOutcome& scan) { return IsTracking(scan) && IsSuccess(scan); }

Incident IncidentAt(const ScanOutcome& scan, std::string what, const std::string& drive,
                    Stamp origin) {
  return {.what = std::move(what),
          .drive = drive,
          .at_s = Seconds(scan.answer.stamp - origin),
          .error_m = scan.error.translation_m,
          .error_deg = scan.error.rotation_deg,
          .nees = scan.error.nees,
          .for_s = 0.0};
}

void AddCovariance(const PoseError& error, bool is_disturbed, Tally& tally) {
  if (error.dof == 0) return;
  const bool inside_95 = error.nees <= ChiSquare95(error.dof);
  if (is_disturbed) {
    tally.disturbed_nees_per_dof_sum += error.nees / error.dof;
    ++tally.disturbed_nees_count;
    if (inside_95) ++tally.disturbed_inside_95;
  }
  tally.nees_per_dof_sum += error.nees / error.dof;
  ++tally.nees_count;
  if (inside_95) ++tally.inside_95;
}

void AddScan(const ScanOutcome& scan, bool is_disturbed, const std::string& drive, Stamp origin,
             Tally& tally) {
  ++tally.scans;
  if (scan.answered()) AddCovariance(scan.error, is_disturbed, tally);
  if (IsTracking(scan)) {
    ++tally.tracking;
    tally.worst_tracking_m = std::max(tally.worst_tracking_m, scan.error.translation_m);
  }
  if (IsSuccess(scan)) {
    ++tally.right;
  } else if (!IsTracking(scan)) {
    ++tally.flagged;
  } else {
    ++tally.wrong;
    if (IsMisleading(scan)) ++tally.misleading;
    tally.Add(IncidentAt(scan, IsMisleading(scan) ? "misleading" : "wrong", drive, origin));
  }
}

// The time from the first of `scans` to the first from which on all track rightly for a while;
// infinite where there is none.
double RecoveryTime(std::span<const ScanOutcome> scans) {
  const auto stamp_of = [&](std::size_t i) { return scans[i].answer.stamp; };
  std::size_t begin = 0;  // of the present run of scans that track rightly
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (!IsRightTracking(scans[i])) {
      begin = i + 1;
    } else if (Seconds(stamp_of(i) - stamp_of(begin)) >= kSteady_s) {
      break;
    }
  }
  if (begin == scans.size()) return std::numeric_limits<double>::infinity();
  return Seconds(stamp_of(begin) - stamp_of(0));
}

void AddEpisode(std::span<const ScanOutcome> after, const std::string& drive, Stamp origin,
                Tally& tally) {
  if (after.empty()) return;
  ++tally.episodes;
  const double recovery_s = RecoveryTime(after);
  if (std::isfinite(recovery_s)) tally.recovery_s.push_back(recovery_s);
  if (recovery_s <= kRecoveryGoal_s) return;
  Incident incident = IncidentAt(after.front(), "slow recovery", drive, origin);
  incident.for_s = recovery_s;
  tally.Add(std::move(incident));
}

// The scans after `begin` and before `end`.
std::span<const ScanOutcome> Between(std::span<const ScanOutcome> scans, Stamp begin, Stamp end) {
  const auto stamp = [](const ScanOutcome& scan) { return scan.answer.stamp; };
  const auto first = std::ranges::upper_bound(scans, begin, {}, stamp);
  const auto last = std::ranges::lower_bound(first, scans.end(), end, {}, stamp);
  return {first, last};
}

}  // namespace

Tally CountScans(const DriveOutcome& outcome, std::span<const Episode> episodes) {
  Tally tally;
  tally.refused = outcome.refused_count;
  if (outcome.scans.empty()) return tally;
  const Stamp origin = outcome.scans.front().answer.stamp;
  const auto is_disturbed = [&](const ScanOutcome& scan) {
    return std::ranges::any_of(episodes, [&](const Episode& episode) {
      return scan.answer.stamp >= episode.begin && scan.answer.stamp <= episode.end;
    });
  };
  bool has_started = false;
  for (const ScanOutcome& scan : outcome.scans) {
    has_started =
        has_started || scan.answered() || Seconds(scan.answer.stamp - origin) > kStartAllowance_s;
    if (has_started) AddScan(scan, is_disturbed(scan), outcome.drive, origin, tally);
  }
  return tally;
}

Tally JudgeTrack(const DriveOutcome& outcome, std::span<const Episode> episodes) {
  Tally tally = CountScans(outcome, episodes);
  if (outcome.scans.empty()) return tally;
  const Stamp origin = outcome.scans.front().answer.stamp;
  const auto first = std::ranges::find_if(outcome.scans, IsRightTracking);
  for (std::size_t i = 0; i < episodes.size(); ++i) {
    if (first == outcome.scans.end() || first->answer.stamp >= episodes[i].begin) continue;
    const Stamp end = i + 1 < episodes.size() ? episodes[i + 1].begin : Stamp::max();
    AddEpisode(Between(outcome.scans, episodes[i].end, end), outcome.drive, origin, tally);
  }
  return tally;
}

Tally JudgeStart(const DriveOutcome& outcome, Stamp origin) {
  Tally tally;
  tally.refused = outcome.refused_count;
  tally.starts = 1;
  if (outcome.scans.empty()) return tally;
  for (const ScanOutcome& scan : outcome.scans) AddScan(scan, false, outcome.drive, origin, tally);
  const ScanOutcome& last = outcome.scans.back();
  const double data_s = Seconds(last.answer.stamp - outcome.scans.front().answer.stamp);
  if (IsRightTracking(last)) {
    tally.right_claim_s.push_back(data_s);
    if (data_s <= kStartGoal_s) return tally;
  } else if (IsTracking(last)) {
    ++tally.wrong_claims;
  }
  Incident incident = IncidentAt(
      last, IsRightTracking(last) ? "slow start" : (IsTracking(last) ? "wrong claim" : "no claim"),
      outcome.drive, origin);
  incident.for_s = data_s;
  tally.Add(std::move(incident));
  return tally;
}

}  // namespace dcloc::robustness
