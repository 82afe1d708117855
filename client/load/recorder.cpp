#include "client/load/recorder.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace dcloc::load {
namespace {

constexpr int kResourceExhausted = 8;

}  // namespace

void Recorder::Begin() {
  const std::lock_guard lock(mutex_);
  measuring_ = true;
  begin_ = Clock::now();
}

void Recorder::End() {
  const std::lock_guard lock(mutex_);
  measuring_ = false;
}

void Recorder::AddOpened(std::chrono::nanoseconds duration) {
  const std::lock_guard lock(mutex_);
  ++record_.totals.opened_count;
  ++vehicle_count_;
  record_.open_latency.Add(duration);
}

void Recorder::AddEnded() {
  const std::lock_guard lock(mutex_);
  --vehicle_count_;
}

void Recorder::AddAnswer(const v1::LocalizeResponse& answer, std::chrono::nanoseconds latency,
                         bool counts_latency) {
  const std::lock_guard lock(mutex_);
  if (!measuring_) return;
  const v1::LocalizationResult& result = answer.result();
  ++record_.totals.answered_count;
  if (result.state() == v1::LOCALIZATION_STATE_TRACKING) ++record_.totals.tracking_count;
  if (result.state() == v1::LOCALIZATION_STATE_LOST) ++record_.totals.lost_state_count;
  if (!counts_latency) return;
  second_.Add(latency);
  record_.latency.Add(latency);
  // Of an answer from memory the timings are those of the first time.
  if (!answer.from_memory()) {
    record_.server_latency.Add(std::chrono::nanoseconds(result.timings().total_duration_ns()));
  }
}

void Recorder::AddError(const PositionError& error) {
  const std::lock_guard lock(mutex_);
  if (!measuring_) return;
  LoadTotals& totals = record_.totals;
  ++totals.judged_count;
  totals.misleading_count += error.misleading ? 1 : 0;
  totals.error_sum_m += error.distance_m;
  totals.max_error_m = std::max(totals.max_error_m, error.distance_m);
}

void Recorder::AddGap(Clock::time_point from, Clock::time_point to) {
  const std::lock_guard lock(mutex_);
  const bool has_begun = begin_ != Clock::time_point();
  if (has_begun && to > begin_) record_.gap.Add(to - std::max(from, begin_));
}

void Recorder::AddRepeated() {
  const std::lock_guard lock(mutex_);
  if (measuring_) ++record_.totals.repeated_count;
}

void Recorder::AddLateRefused() {
  const std::lock_guard lock(mutex_);
  if (measuring_) ++record_.totals.late_refused_count;
}

void Recorder::AddRejected(const v1::ScanRejected& rejected) {
  const std::lock_guard lock(mutex_);
  if (rejected.code() == kResourceExhausted) {
    ++record_.totals.dropped_count;
  } else {
    record_.totals.refused.Note(absl::StrCat(rejected.message(), " (code ", rejected.code(), ")"));
  }
}

void Recorder::AddSkipped() {
  const std::lock_guard lock(mutex_);
  if (measuring_) ++record_.totals.skipped_count;
}

void Recorder::AddLost(std::int64_t count) {
  const std::lock_guard lock(mutex_);
  record_.totals.lost_count += count;
}

void Recorder::AddMoved() {
  const std::lock_guard lock(mutex_);
  ++record_.totals.moved_count;
}

void Recorder::AddRestarted() {
  const std::lock_guard lock(mutex_);
  ++record_.totals.restart_count;
}

void Recorder::AddDisconnect() {
  const std::lock_guard lock(mutex_);
  ++record_.totals.disconnect_count;
}

void Recorder::AddStall() {
  const std::lock_guard lock(mutex_);
  ++record_.totals.stall_count;
}

void Recorder::AddBroken(const std::string& text) {
  const std::lock_guard lock(mutex_);
  record_.totals.broken.Note(text);
}

void Recorder::AddViolation(const std::string& text) {
  const std::lock_guard lock(mutex_);
  record_.totals.violations.Note(text);
}

LoadSecond Recorder::EndSecond() {
  const std::lock_guard lock(mutex_);
  const LoadSecond second{
      .time_s = measuring_ ? std::chrono::duration<double>(Clock::now() - begin_).count() : 0.0,
      .vehicle_count = vehicle_count_,
      .answered_count = second_.count(),
      .p50_ms = second_.QuantileMs(0.5),
      .p99_ms = second_.QuantileMs(0.99),
      .max_ms = second_.max_ms()};
  if (measuring_) record_.seconds.push_back(second);
  second_.Clear();
  return second;
}

LoadRecord Recorder::record() const {
  const std::lock_guard lock(mutex_);
  return record_;
}

}  // namespace dcloc::load
