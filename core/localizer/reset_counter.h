#pragma once

#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/localizer/pose_resets.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// Which changes of the answered pose, beyond how the vehicle moved, count as resets.
struct ResetOptions {
  double min_reset_m = 0.3;
  double min_reset_rad = 0.02;
};
std::span<const OptionField<ResetOptions>> FieldsOf(const ResetOptions& options);
absl::Status Validate(const ResetOptions& options);

/// Counts the resets of the answered pose.
class ResetCounter {
 public:
  explicit ResetCounter(const ResetOptions& options) : options_(options) {}

  /// The vehicle moved so since the last call.
  void OnMotion(const Pose3& T_from_to) {
    if (expected_) expected_ = *expected_ * T_from_to;
  }

  /// This is answered. The first pose is no reset. Returns by how much a reset moved the position
  /// [m]; 0 where there is none.
  double OnAnswer(const Pose3& T_map_vehicle);

  /// Goes on from what an earlier localizer of the same vehicle counted, and from its last answer.
  void Restore(const PoseResets& resets, const Pose3& T_map_vehicle) {
    resets_ = resets;
    expected_ = T_map_vehicle;
  }

  const PoseResets& resets() const { return resets_; }

 private:
  ResetOptions options_;
  std::optional<Pose3> expected_;  // the last answer, carried on
  PoseResets resets_;
};

}  // namespace dcloc
