#include "client/evaluation/faults/judgement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "client/evaluation/metrics.h"
#include "client/evaluation/robustness/judgement.h"

namespace dcloc::faults {
namespace {

using std::chrono::nanoseconds;

double SecondsFrom(Stamp from, Stamp to) {
  return std::chrono::duration<double>(to - from).count();
}

bool Tracks(const ScanOutcome& scan) { return scan.answer.state == LocalizationState::kTracking; }

void AddAnswer(const ScanOutcome& scan, const std::optional<double>& level_m, bool is_meanwhile,
               Record& record) {
  if (is_meanwhile) {
    ++record.meanwhile_scans;
    if (Tracks(scan)) ++record.meanwhile_tracking;
  }
  if (!scan.answered()) return;
  record.errors_m.push_back(scan.error.translation_m);
  if (is_meanwhile) record.meanwhile_errors_m.push_back(scan.error.translation_m);
  if (level_m && Tracks(scan)) record.stanford.Add(scan.error.translation_m, *level_m);
}

}  // namespace

double SecondsUntilRight(std::span<const ScanOutcome> scans, Stamp end) {
  std::optional<Stamp> begin, last;  // of the present run of answers that are right
  for (const ScanOutcome& scan : scans) {
    const Stamp stamp = scan.answer.stamp;
    if (stamp < end) continue;
    if (!Tracks(scan) || !IsSuccess(scan)) {
      begin.reset();
      continue;
    }
    if (!begin || SecondsFrom(*last, stamp) > kMaxPause_s) begin = stamp;
    last = stamp;
    if (SecondsFrom(*begin, stamp) >= robustness::kSteady_s) return SecondsFrom(end, *begin);
  }
  return std::numeric_limits<double>::infinity();
}

Record JudgeFault(const SessionOutcome& outcome, const Window& window) {
  // An episode's end belongs to it; a moment has no scan.
  std::vector<Episode> episodes;
  if (window.begin < window.end) episodes.push_back({window.begin, window.end - nanoseconds(1)});
  Record record{.cases = 1, .arrived = outcome.arrived};
  record.tally = robustness::CountScans(outcome.drive, episodes);
  record.longest_call_ms = outcome.longest_call_ms;
  if (!outcome.failure.empty()) {
    record.failures.push_back(absl::StrCat(outcome.drive.drive, ": ", outcome.failure));
  }
  const std::vector<ScanOutcome>& scans = outcome.drive.scans;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    AddAnswer(scans[i], outcome.protection_level_m[i], window.Contains(scans[i].answer.stamp),
              record);
  }
  if (window.is_open()) return record;
  record.tally.episodes = 1;
  const double recovery_s = SecondsUntilRight(scans, window.end);
  if (std::isfinite(recovery_s)) record.tally.recovery_s.push_back(recovery_s);
  return record;
}

}  // namespace dcloc::faults
