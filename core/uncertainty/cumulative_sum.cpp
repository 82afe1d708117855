#include "core/uncertainty/cumulative_sum.h"

namespace dcloc {

std::span<const OptionField<CumulativeSumOptions>> FieldsOf(
    const CumulativeSumOptions& /*options*/) {
  using O = CumulativeSumOptions;
  static constexpr OptionField<O> kFields[] = {
      {"drift", &O::drift, 0, 1e6, "each deviation counts"},
      {"max", &O::max, 1e-6, 1e6},
      {"limit", &O::limit, 1e-6, 1e9},
  };
  return kFields;
}

absl::Status Validate(const CumulativeSumOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

}  // namespace dcloc
