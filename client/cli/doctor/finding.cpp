#include "client/cli/doctor/finding.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "absl/strings/str_format.h"
#include "client/cli/common/terminal.h"

namespace dcloc::cli {

const char* NameOf(CheckResult result) {
  switch (result) {
    case CheckResult::kOk:
      return "ok";
    case CheckResult::kWarning:
      return "warning";
    case CheckResult::kFailed:
      return "failed";
    case CheckResult::kSkipped:
      return "skipped";
  }
  return "unknown";
}

CheckResult WorstOf(const Findings& findings) {
  const auto has = [&](CheckResult result) {
    return std::ranges::find(findings, result, &Finding::result) != findings.end();
  };
  if (has(CheckResult::kFailed)) return CheckResult::kFailed;
  return has(CheckResult::kWarning) ? CheckResult::kWarning : CheckResult::kOk;
}

std::string FindingsText(const Findings& findings) {
  std::size_t width = 0;
  for (const Finding& finding : findings) width = std::max(width, finding.check.size());
  std::string text;
  for (const Finding& finding : findings) {
    absl::StrAppendFormat(&text, "%-7s  %-*s  %s\n", NameOf(finding.result), width,
                          Visible(finding.check), Visible(finding.what));
    if (finding.advice.empty()) continue;
    absl::StrAppendFormat(&text, "%-7s  %-*s  -> %s\n", "", width, "", Visible(finding.advice));
  }
  return text;
}

nlohmann::ordered_json FindingsJson(const Findings& findings) {
  nlohmann::ordered_json checks = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    checks.push_back({{"check", finding.check},
                      {"result", NameOf(finding.result)},
                      {"what", finding.what},
                      {"advice", finding.advice}});
  }
  return {{"result", NameOf(WorstOf(findings))}, {"checks", std::move(checks)}};
}

}  // namespace dcloc::cli
