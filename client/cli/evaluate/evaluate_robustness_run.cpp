#include "client/cli/evaluate/evaluate_robustness_run.h"

#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/campaign_progress.h"
#include "client/cli/common/terminal.h"
#include "client/cli/evaluate/result_folder.h"
#include "client/evaluation/robustness/report.h"
#include "client/evaluation/robustness/sites.h"

namespace dcloc::cli {
namespace {

namespace fs = std::filesystem;

absl::StatusOr<std::vector<robustness::Site>> AllSites(const RobustnessArguments& arguments) {
  std::vector<robustness::Site> sites = robustness::SimulatedSites(arguments.seed, arguments.quick);
  if (arguments.data.empty()) return sites;
  auto recorded = robustness::RecordedSites(arguments.data, arguments.seed);
  if (!recorded.ok()) return recorded.status();
  for (robustness::Site& site : *recorded) sites.push_back(std::move(site));
  return sites;
}

std::vector<std::pair<std::string, std::string>> Settings(const RobustnessArguments& arguments,
                                                          std::size_t site_count) {
  return {{"Places", absl::StrCat(site_count, ", each with a map and a live drive")},
          {"Recordings", arguments.data.empty() ? "none (--data)" : arguments.data},
          {"Simulated", "mapped at 72 km/h, driven at 40 to 100 km/h, beta 0.04 s"},
          {"Seed", absl::StrCat(arguments.seed)},
          {"Extent", arguments.quick ? "quick: numbers of no meaning" : "full"}};
}

absl::Status WriteCampaignFile(const fs::path& path, const std::string& text) {
  return WriteFileAtomically(path, std::as_bytes(std::span(text)));
}

}  // namespace

absl::Status RunRobustness(const RobustnessArguments& arguments) {
  const fs::path folder = arguments.folder;
  if (absl::Status status = MakeFolder(folder / "runs"); !status.ok()) return status;
  const auto sites = AllSites(arguments);
  if (!sites.ok()) return sites.status();
  ResultFolder<robustness::Tally> store(
      {folder / "runs", absl::StrCat(ProgramHash(), arguments.quick ? " quick " : " ",
                                     arguments.seed, " ", arguments.data)},
      robustness::TallyFromJson, robustness::TallyToJson);
  CampaignProgress progress;
  const auto results = robustness::RunCampaign(
      *sites, store, [&](const std::string& name, double share) { progress.Update(name, share); });
  if (!results.ok()) return results.status();
  progress = {};

  absl::PrintF("%s\n%s\n%s", FormatTable(robustness::TrackText(*results, false)),
               FormatTable(robustness::StartText(*results, true)),
               FormatTable(robustness::GoalText(robustness::JudgeGoals(*results))));
  absl::Status status =
      WriteCampaignFile(folder / "results.json", robustness::CampaignJson(*results).dump(2) + "\n");
  status.Update(
      WriteCampaignFile(folder / "report.html",
                        robustness::CampaignHtml(*results, Settings(arguments, sites->size()))));
  return status;
}

}  // namespace dcloc::cli
