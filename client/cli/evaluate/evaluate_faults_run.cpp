#include "client/cli/evaluate/evaluate_faults_run.h"

#include <filesystem>
#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/campaign_progress.h"
#include "client/cli/common/terminal.h"
#include "client/cli/evaluate/result_folder.h"
#include "client/evaluation/faults/report.h"
#include "client/evaluation/faults/report_json.h"
#include "client/evaluation/faults/stanford_picture.h"

namespace dcloc::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNoLevels = "Left out: no answer has a protection level.";

std::vector<std::pair<std::string, std::string>> FaultSettings(const FaultArguments& arguments,
                                                               const faults::Selection& selection) {
  return {{"Worlds", absl::StrCat(selection.worlds.size(), ", each with a map and a live drive")},
          {"Faults", absl::StrCat(selection.faults.size())},
          {"Only", arguments.only.empty() ? "everything" : absl::StrJoin(arguments.only, ", ")},
          {"First pose", "0.5 m and 2 degrees off, but where the fault is about it"},
          {"Seed", absl::StrCat(arguments.seed)},
          {"Extent", arguments.quick ? "quick: numbers of no meaning" : "full"}};
}

/// The diagram, and a remark on it.
std::pair<std::string, std::string> Stanford(std::span<const faults::FaultRows> rows) {
  faults::StanfordHistogram histogram;
  for (const faults::FaultRows& row : rows) Merge(row.all.record.stanford, histogram);
  if (histogram.answers == 0) return {"", kNoLevels};
  auto svg = RenderSvg(faults::StanfordPicture(histogram));
  if (!svg.ok()) return {"", absl::StrCat("Left out: ", svg.status().message())};
  return {*std::move(svg),
          absl::StrFormat("%d TRACKING answers, %d with an error above their protection level.",
                          histogram.answers, histogram.exceeded)};
}

absl::Status WriteFaultFile(const fs::path& path, const std::string& text) {
  return WriteFileAtomically(path, std::as_bytes(std::span(text)));
}

}  // namespace

absl::Status RunFaults(const FaultArguments& arguments) {
  auto selection = faults::Select({faults::AllFaults(arguments.quick),
                                   faults::SimulatedWorlds(arguments.seed, arguments.quick)},
                                  arguments.only);
  if (!selection.ok()) return selection.status();
  const fs::path folder = arguments.folder;
  if (absl::Status status = MakeFolder(folder / "runs"); !status.ok()) return status;
  ResultFolder<faults::Record> store(
      {folder / "runs",
       absl::StrCat(ProgramHash(), arguments.quick ? " quick " : " ", arguments.seed)},
      faults::RecordFromJson, faults::RecordToJson);
  CampaignProgress progress;
  const auto results = faults::RunFaultCampaign(
      *selection, store, arguments.jobs,
      [&](const std::string& name, double share) { progress.Update(name, share); });
  if (!results.ok()) return results.status();
  progress = {};

  const std::vector<faults::FaultRows> rows = faults::RowsOf(*results, selection->faults);
  const std::string json = faults::FaultJson(rows, *results).dump(2) + "\n";
  const auto [svg, remark] = Stanford(rows);
  if (arguments.json) {
    absl::PrintF("%s", json);
  } else {
    absl::PrintF("%s", FormatTable(faults::FaultText(rows, false)));
    const robustness::TextTable failures = faults::FailureText(rows);
    if (failures.size() > 1) absl::PrintF("\n%s", FormatTable(failures));
    absl::PrintF("\nStanford diagram: %s\n", remark);
  }
  absl::Status status = WriteFaultFile(folder / "results.json", json);
  status.Update(
      WriteFaultFile(folder / "report.html",
                     faults::FaultHtml(rows, FaultSettings(arguments, *selection), svg, remark)));
  return status;
}

}  // namespace dcloc::cli
