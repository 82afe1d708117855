#include "core/uncertainty/one_sided_cusum.h"

namespace dcloc {

std::span<const OptionField<OneSidedCusumOptions>> FieldsOf(
    const OneSidedCusumOptions& /*options*/) {
  using O = OneSidedCusumOptions;
  static constexpr OptionField<O> kFields[] = {
      {"drift", &O::drift, 0, 1e6, "each deviation counts"},
      {"max", &O::max, 1e-6, 1e6},
      {"limit", &O::limit, 1e-6, 1e9},
  };
  return kFields;
}

absl::Status Validate(const OneSidedCusumOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

}  // namespace dcloc
