#include "client/cli/localize/trust_summary.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "client/cli/remote/answer_text.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

/// Of `values`, which are sorted and not empty.
double Quantile(const std::vector<double>& values, double share) {
  const double rank = share * static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::lround(rank))];
}

std::string JumpText(const v1::PoseResets& resets) {
  const v1::Vector3& jump = resets.last_jump().translation_m();
  return absl::StrFormat("the pose jumped by %.2f m", std::hypot(jump.x(), jump.y(), jump.z()));
}

}  // namespace

std::string TrustSummary::Add(const v1::LocalizationResult& result) {
  ++answer_count_;
  if (result.has_protection_level_m()) {
    protection_levels_m_.push_back(result.protection_level_m());
  }
  std::vector<std::string> news;
  std::string set_aside = SetAsideText(result.health());
  for (const absl::string_view source : absl::StrSplit(set_aside, ", ", absl::SkipEmpty())) {
    ++set_aside_counts_[std::string(source)];
  }
  if (set_aside != set_aside_) {
    news.push_back(set_aside.empty() ? "all sources are used" : "without " + set_aside);
  }
  set_aside_ = std::move(set_aside);
  if (result.resets().count() > reset_count_) news.push_back(JumpText(result.resets()));
  reset_count_ = result.resets().count();
  if (news.empty()) return "";
  return absl::StrCat("scan ", result.sequence_number(), ": ", absl::StrJoin(news, "; "));
}

void TrustSummary::Add(const v1::PositionFixAnswer& answer) {
  ++fix_counts_[UseText(answer.use())];
  if (first_invalid_fix_.empty()) first_invalid_fix_ = answer.message();
}

std::string TrustSummary::Text() const {
  std::string text;
  for (const auto& [source, count] : set_aside_counts_) {
    absl::StrAppendFormat(&text, "%d of %d answers are without %s.\n", count, answer_count_,
                          source);
  }
  if (reset_count_ > 0) absl::StrAppendFormat(&text, "The pose jumped %d times.\n", reset_count_);
  if (std::vector<double> levels = protection_levels_m_; !levels.empty()) {
    std::ranges::sort(levels);
    absl::StrAppendFormat(
        &text, "%d of %d answers have a protection level: median %.2f m, p99 %.2f m.\n",
        levels.size(), answer_count_, Quantile(levels, 0.5), Quantile(levels, 0.99));
  }
  if (!fix_counts_.empty()) {
    const auto each = [](std::string* out, const auto& entry) {
      absl::StrAppend(out, entry.second, " ", entry.first);
    };
    absl::StrAppend(&text, "Position fixes: ", absl::StrJoin(fix_counts_, ", ", each), ".\n");
  }
  if (!first_invalid_fix_.empty()) {
    absl::StrAppend(&text, "The first fix that was refused: ", first_invalid_fix_, "\n");
  }
  return text;
}

ordered_json TrustSummary::Json() const {
  ordered_json json = {{"set_aside", set_aside_counts_},
                       {"reset_count", reset_count_},
                       {"protection_level_m", nullptr},
                       {"fixes", fix_counts_},
                       {"first_invalid_fix", first_invalid_fix_}};
  if (std::vector<double> levels = protection_levels_m_; !levels.empty()) {
    std::ranges::sort(levels);
    json["protection_level_m"] = {{"count", levels.size()},
                                  {"median", Quantile(levels, 0.5)},
                                  {"p99", Quantile(levels, 0.99)},
                                  {"max", levels.back()}};
  }
  return json;
}

}  // namespace dcloc::cli
