#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/chi_square.h"
#include "core/geometry/pose_estimate.h"
#include "core/odometry/motion_history.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// When fixes agree with the pose of the radars, and when they are fused.
struct FixMonitorOptions {
  /// A fix agrees with the pose up to this squared Mahalanobis distance of the two positions.
  double max_squared_distance = kChiSquare999With2Dof;
  /// A fix agrees with the pose up to this squared Mahalanobis distance of the two headings.
  double max_squared_heading_distance = kChiSquare999With1Dof;
  /// A fix whose heading is less certain than this has none.
  double unknown_heading_sigma_rad = 1.0;
  /// Fixes in a row that must contradict the pose for the contradiction to be persistent.
  int persistent_fixes = 3;
  /// The time that these fixes must span, at least.
  std::chrono::nanoseconds persistent_span = std::chrono::milliseconds(800);
  /// Fixes are ignored for this long after the radars have refuted them.
  std::chrono::nanoseconds refuted_span = std::chrono::seconds(30);
  /// One fix is fused within this time: errors of fixes are correlated.
  std::chrono::nanoseconds fusion_interval = std::chrono::seconds(1);
  /// A fix is fused if its position's standard deviation is at most this multiple of the pose's.
  double fusion_sigma_factor = 2.0;
};
std::span<const OptionField<FixMonitorOptions>> FieldsOf(const FixMonitorOptions& options);
absl::Status Validate(const FixMonitorOptions& options);

/// What a fix says of a pose.
enum class FixVerdict {
  kAgrees,                   ///< nothing that the pose does not know better
  kFusable,                  ///< it agrees, and makes the pose more certain
  kContradicts,              ///< it is elsewhere: one of the two is wrong
  kContradictsPersistently,  ///< as those before it did: the pose must be held against other places
};

/// Holds fixes against the pose. A single one may be a reflection; several make the pose doubted,
/// and the radars decide.
class FixMonitor {
 public:
  explicit FixMonitor(const FixMonitorOptions& options) : options_(options) {}

  /// Both in the map frame, at `stamp`.
  FixVerdict Classify(Stamp stamp, const PoseEstimate<3>& fix, const PoseEstimate<3>& pose);

  /// The fix that was judged to inform was fused.
  void OnFused() { fused_ = newest_; }

  /// The radars have confirmed the pose against the fixes so far.
  void OnRefuted() {
    if (contradicting_count_ > 0) refuted_ = newest_;
    contradicting_count_ = 0;
  }

 private:
  bool Agree(const PoseEstimate<3>& fix, const PoseEstimate<3>& pose) const;
  bool IsFusable(Stamp stamp, const PoseEstimate<3>& fix, const PoseEstimate<3>& pose) const;
  bool IsRefuted(Stamp stamp) const {
    return refuted_ && stamp - *refuted_ < options_.refuted_span;
  }

  FixMonitorOptions options_;
  Stamp newest_{};
  std::optional<Stamp> fused_;
  std::optional<Stamp> refuted_;
  int contradicting_count_ = 0;  // in a row
  Stamp contradicting_since_{};
};

/// Where a fix of `stamp` puts the vehicle at the newest scan, by how it has moved since; nothing
/// where that is not known. Before the first scan, as it says. A fix without a heading has that of
/// `pose`, where there is one: the pose at the newest scan.
std::optional<PoseEstimate<3>> CarriedToNow(const PoseEstimate<3>& fix, Stamp stamp,
                                            const std::optional<PoseEstimate<3>>& pose,
                                            const MotionHistory& history,
                                            const FixMonitorOptions& options);

/// What a fix says of the position alone: how the vehicle is turned, radars know better.
PoseEstimate<3> PositionOf(const PoseEstimate<3>& fix);

/// A fix with the heading of `pose` where it knows none.
PoseEstimate<3> WithHeadingOf(const PoseEstimate<3>& pose, PoseEstimate<3> fix,
                              const FixMonitorOptions& options);

}  // namespace dcloc
