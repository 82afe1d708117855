#include "core/localizer/reset_counter.h"

namespace dcloc {

std::span<const OptionField<ResetOptions>> FieldsOf(const ResetOptions& /*options*/) {
  using O = ResetOptions;
  static constexpr OptionField<O> kFields[] = {
      {"min_reset_m", &O::min_reset_m, 0, 1e6, "every correction is a reset"},
      {"min_reset_rad", &O::min_reset_rad, 0, 10, "every correction is a reset"},
  };
  return kFields;
}

absl::Status Validate(const ResetOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

double ResetCounter::OnAnswer(const Pose3& T_map_vehicle) {
  double moved_m = 0.0;
  if (expected_) {
    const Pose3 T_before_after = expected_->Inverse() * T_map_vehicle;
    const Vector6d change = Log(T_before_after);
    if (T_before_after.translation_m.norm() > options_.min_reset_m ||
        change.tail<3>().norm() > options_.min_reset_rad) {
      ++resets_.count;
      resets_.T_before_after = T_before_after;
      moved_m = T_before_after.translation_m.head<2>().norm();
    }
  }
  expected_ = T_map_vehicle;
  return moved_m;
}

}  // namespace dcloc
