#include "client/cli/evaluate/evaluate_paper_run.h"

#include <filesystem>
#include <fstream>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/campaign_progress.h"
#include "client/cli/common/terminal.h"
#include "client/cli/evaluate/result_folder.h"
#include "client/evaluation/gnuplot.h"
#include "client/evaluation/paper/goals.h"
#include "client/evaluation/paper/outcome_json.h"
#include "client/evaluation/paper/paper_report.h"
#include "client/evaluation/paper/recorded_cases.h"
#include "client/evaluation/paper/simulated_cases.h"
#include "client/evaluation/paper/tables.h"

namespace dcloc::cli {
namespace {

namespace fs = std::filesystem;

absl::StatusOr<std::vector<paper::Case>> AllCases(const PaperArguments& arguments) {
  std::vector<paper::Case> cases = paper::SimulatedCases(arguments.quick);
  if (arguments.data.empty()) return cases;
  auto recorded = paper::RecordedCases(arguments.data);
  if (!recorded.ok()) return recorded.status();
  for (paper::Case& item : *recorded) cases.push_back(std::move(item));
  return cases;
}

std::vector<std::pair<std::string, std::string>> Settings(const PaperArguments& arguments,
                                                          std::size_t case_count) {
  return {{"Drives", absl::StrCat(case_count, " pairs of a map drive and a live drive")},
          {"Recordings", arguments.data.empty() ? "none (--data)" : arguments.data},
          {"Simulated",
           "map at 72 km/h, live at 20 to 100 km/h and with stops, beta 0.04 s as in the paper"},
          {"First pose", "truth moved by 1 m and turned by 2 degrees"},
          {"Sub-map", "10 scans of each radar where nothing else is said"},
          {"Extent", arguments.quick ? "quick: numbers of no meaning" : "full"},
          {"Finished runs", arguments.keep_runs ? "taken, of whatever build" : "this build's"}};
}

absl::Status WriteText(const fs::path& path, const std::string& text) {
  return WriteFileAtomically(path, std::as_bytes(std::span(text)));
}

// What runs are marked with: this build and what it is to run, or what `file` says of an earlier
// call, where its runs are to be kept.
absl::StatusOr<std::string> Fingerprint(const PaperArguments& arguments, const fs::path& file) {
  if (arguments.keep_runs) {
    std::ifstream kept(file);
    if (std::string line; std::getline(kept, line)) return line;
  }
  std::string fingerprint =
      absl::StrCat(ProgramHash(), arguments.quick ? " quick " : " ", arguments.data);
  if (absl::Status status = WriteText(file, fingerprint + "\n"); !status.ok()) return status;
  return fingerprint;
}

}  // namespace

absl::Status RunPaper(const PaperArguments& arguments) {
  // Missing gnuplot is to be known before an hour's work, not after it.
  if (const auto picture = RenderSvg({.commands = "plot x"}); !picture.ok()) {
    return picture.status();
  }
  const fs::path folder = arguments.folder;
  if (absl::Status status = MakeFolder(folder / "runs"); !status.ok()) return status;
  const auto cases = AllCases(arguments);
  if (!cases.ok()) return cases.status();
  const auto fingerprint = Fingerprint(arguments, folder / "runs" / "fingerprint");
  if (!fingerprint.ok()) return fingerprint.status();
  ResultFolder<DriveOutcome> runs({folder / "runs", *fingerprint}, paper::OutcomeFromJson,
                                  paper::OutcomeToJson);
  CampaignProgress progress;
  const auto results = paper::RunStudy(
      *cases, arguments.quick, runs,
      [&](const std::string& run_name, double share) { progress.Update(run_name, share); });
  if (!results.ok()) return results.status();
  progress = {};

  const auto tables = paper::StudyTables(*results);
  absl::PrintF("%s\n%s", FormatTable(paper::SummaryText(tables)),
               FormatTable(paper::GoalsText(paper::Goals(*results, tables))));
  absl::Status status =
      WriteText(folder / "results.json", paper::StudyJson(*results).dump(2) + "\n");
  const auto html = paper::StudyHtml(*results, Settings(arguments, cases->size()), folder);
  if (!html.ok()) return html.status();
  status.Update(WriteText(folder / "report.html", *html));
  return status;
}

}  // namespace dcloc::cli
