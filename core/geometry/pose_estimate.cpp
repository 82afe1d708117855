#include "core/geometry/pose_estimate.h"

namespace dcloc {

std::span<const OptionField<UnobservedSigmas>> FieldsOf(const UnobservedSigmas& /*options*/) {
  using O = UnobservedSigmas;
  static constexpr OptionField<O> kFields[] = {
      {"z_m", &O::z_m, 1e-6, 1000},
      {"tilt_rad", &O::tilt_rad, 1e-6, 1},
  };
  return kFields;
}

absl::Status Validate(const UnobservedSigmas& options) {
  return ValidateFields(options, FieldsOf(options));
}

}  // namespace dcloc
