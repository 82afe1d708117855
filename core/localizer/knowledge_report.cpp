#include "core/localizer/knowledge_report.h"

namespace dcloc {

std::span<const OptionField<KnowledgeReportOptions>> FieldsOf(
    const KnowledgeReportOptions& /*options*/) {
  using O = KnowledgeReportOptions;
  static constexpr OptionField<O> kFields[] = {
      {"interval_ms", &O::interval, 1, 1e7},
      {"max_beta_sigma_s", &O::max_beta_sigma_s, 0, 10, "no beta is reported"},
  };
  return kFields;
}

absl::Status Validate(const KnowledgeReportOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

bool KnowledgeReport::IsDue(Stamp stamp) {
  if (!last_look_) last_look_ = stamp;
  if (stamp - *last_look_ < options_.interval) return false;
  last_look_ = stamp;
  return true;
}

std::optional<RigKnowledge> KnowledgeReport::OnKnown(const RigKnowledge& known) {
  if (!HasChanged(last_reported_, known)) return std::nullopt;
  last_reported_ = known;
  return last_reported_;
}

}  // namespace dcloc
