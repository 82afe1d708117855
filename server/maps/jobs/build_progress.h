#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "dcloc/v1/map_service.pb.h"

namespace dcloc::server {

/// How far a build is: told by its thread, read by others, who may stop it. Thread-safe.
class BuildProgress {
 public:
  /// `begin` has what is known before the build begins.
  explicit BuildProgress(v1::MapBuild begin) : build_(std::move(begin)) {}

  /// Says whether to go on.
  bool Tell(absl::string_view stage, double share) {
    const std::lock_guard lock(mutex_);
    build_.set_stage(std::string(stage));
    build_.set_stage_share(share);
    return !stopped_;
  }

  /// Of a build that finds its scans itself: so many there are.
  void SetScanCount(std::int64_t count) {
    const std::lock_guard lock(mutex_);
    build_.set_scan_count(count);
  }

  /// So many further scans are in the map.
  void CountScans(std::size_t count) { done_scan_count_ += static_cast<std::int64_t>(count); }

  void AddDrive(v1::MapBuildDriveResult drive) {
    const std::lock_guard lock(mutex_);
    *build_.add_drives() = std::move(drive);
  }

  void AddRadar(v1::SurveyedRadar radar) {
    const std::lock_guard lock(mutex_);
    *build_.add_radars() = std::move(radar);
  }

  void SetUpdate(v1::MapUpdateResult update) {
    const std::lock_guard lock(mutex_);
    *build_.mutable_update() = std::move(update);
  }

  /// The build is to end without a version.
  void Stop() { stopped_ = true; }
  bool stopped() const { return stopped_; }

  v1::MapBuild Get() const {
    const std::lock_guard lock(mutex_);
    v1::MapBuild build = build_;
    build.set_done_scan_count(done_scan_count_);
    return build;
  }

 private:
  std::atomic<bool> stopped_ = false;
  std::atomic<std::int64_t> done_scan_count_ = 0;
  mutable std::mutex mutex_;
  v1::MapBuild build_;
};

inline absl::Status BuildStopped() { return absl::CancelledError("cancelled"); }

}  // namespace dcloc::server
