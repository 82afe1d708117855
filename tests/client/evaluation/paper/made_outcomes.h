#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/evaluation/paper/study.h"

namespace dcloc::paper {

/// That long after the epoch.
inline Stamp At(double time_s) {
  return Stamp(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(time_s)));
}

/// A tracked answer `time_s` after the epoch, as far off as said.
inline ScanOutcome MadeScan(double time_s, double rte_m, double rre_deg,
                            std::optional<double> speed_difference_mps = std::nullopt) {
  ScanOutcome scan;
  scan.radar_id = "front";
  scan.answer.stamp = At(time_s);
  scan.answer.state = LocalizationState::kTracking;
  scan.error.translation_m = rte_m;
  scan.error.rotation_deg = rre_deg;
  scan.error.dof = 3;
  scan.error.nees = 3.0;
  scan.total_ms = 1.0;
  scan.speed_difference_mps = speed_difference_mps;
  return scan;
}

inline DriveOutcome MadeOutcome(std::vector<ScanOutcome> scans) {
  return {.drive = "made", .scans = std::move(scans)};
}

/// Answers at whole seconds, with these translation errors and a hundredth of them as degrees.
inline DriveOutcome WithErrors(const std::vector<double>& rte_m) {
  DriveOutcome outcome = MadeOutcome({});
  for (std::size_t i = 0; i < rte_m.size(); ++i) {
    outcome.scans.push_back(MadeScan(static_cast<double>(i), rte_m[i], rte_m[i] / 100.0));
  }
  return outcome;
}

inline RunResult MadeResult(const std::string& set, const std::string& name, const Variant& variant,
                            DriveOutcome outcome, Protocol protocol = Protocol::kTrack) {
  return {set, name, variant, protocol, std::move(outcome)};
}

}  // namespace dcloc::paper
