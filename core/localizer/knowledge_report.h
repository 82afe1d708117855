#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/odometry/rig_knowledge.h"
#include "core/options/option_fields.h"
#include "core/radar/scan.h"

namespace dcloc {

struct KnowledgeReportOptions {
  /// What was learned is looked at, and so reported, no more often than this.
  std::chrono::nanoseconds interval = std::chrono::seconds(5);
  /// A beta that is less certain than this is not reported.
  double max_beta_sigma_s = 0.02;
};
std::span<const OptionField<KnowledgeReportOptions>> FieldsOf(
    const KnowledgeReportOptions& options);
absl::Status Validate(const KnowledgeReportOptions& options);

/// Decides when an answer reports what was learned of the rig: where it has changed, at a bounded
/// rate.
class KnowledgeReport {
 public:
  explicit KnowledgeReport(const KnowledgeReportOptions& options) : options_(options) {}

  /// Whether it is time to look at what is known. The first look is one interval after the first
  /// call.
  bool IsDue(Stamp stamp);

  /// What is to be reported of `known`: all of it, or nothing.
  std::optional<RigKnowledge> OnKnown(const RigKnowledge& known);

 private:
  KnowledgeReportOptions options_;
  std::optional<Stamp> last_look_;
  RigKnowledge last_reported_;
};

}  // namespace dcloc
