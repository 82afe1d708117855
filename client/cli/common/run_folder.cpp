#include "client/cli/common/run_folder.h"

#include "client/evaluation/paper/outcome_json.h"

namespace dcloc::cli {

std::optional<DriveOutcome> RunFolder::Load(const std::string& run_name) {
  const auto json = files_.Load(run_name);
  return json ? paper::OutcomeFromJson(*json) : std::nullopt;
}

absl::Status RunFolder::Save(const std::string& run_name, const DriveOutcome& outcome) {
  return files_.Save(run_name, paper::OutcomeToJson(outcome));
}

}  // namespace dcloc::cli
