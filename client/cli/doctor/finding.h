#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace dcloc::cli {

/// What a check came to.
enum class CheckResult {
  kOk,
  kWarning,  ///< it works, or may work, but not as it should
  kFailed,
  kSkipped,  ///< could not be tried, as `what` says
};

/// "ok", "warning", "failed", "skipped".
const char* NameOf(CheckResult result);

/// One check of `dcloc doctor`.
struct Finding {
  std::string check;  ///< what was checked: "certificate", "radar front: beta"
  CheckResult result = CheckResult::kOk;
  std::string what;    ///< what was found
  std::string advice;  ///< what to do; empty where nothing is to be done
};

using Findings = std::vector<Finding>;

/// The worst result: failed, then warning, then ok.
CheckResult WorstOf(const Findings& findings);

/// A line each with the advice below it: for people.
std::string FindingsText(const Findings& findings);

/// For scripts: {"result": ..., "checks": [...]}.
nlohmann::ordered_json FindingsJson(const Findings& findings);

}  // namespace dcloc::cli
