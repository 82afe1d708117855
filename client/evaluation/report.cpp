#include "client/evaluation/report.h"

#include <algorithm>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "client/evaluation/drive_picture.h"
#include "client/evaluation/html.h"
#include "client/evaluation/metrics_format.h"
#include "client/trajectory/file_of_drive.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

// Columns: each drive in each run, then all drives in each run.
std::string SummaryTable(const Report& report) {
  std::vector<std::pair<std::string, Metrics>> columns;
  const std::size_t drive_count = report.runs.front().outcomes.size();
  for (std::size_t i = 0; i < drive_count; ++i) {
    for (const ReportRun& run : report.runs) {
      columns.emplace_back(absl::StrCat(run.outcomes[i].drive, ", ", run.label),
                           ComputeMetrics({&run.outcomes[i], 1}));
    }
  }
  for (const ReportRun& run : report.runs) {
    if (drive_count > 1) columns.emplace_back("all, " + run.label, ComputeMetrics(run.outcomes));
  }
  return HtmlTable(MetricsRows(columns));
}

std::string Settings(const Report& report) {
  std::string list = "<dl>\n";
  for (const auto& [name, value] : report.settings) {
    absl::StrAppend(&list, "<dt>", EscapeHtml(name), "</dt><dd>", EscapeHtml(value), "</dd>\n");
  }
  return list + "</dl>\n";
}

fs::path PngPath(const fs::path& html, const std::string& drive, bool is_only_one) {
  const fs::path png = fs::path(html).replace_extension(".png");
  return is_only_one ? png : FileOfDrive(png, drive);
}

bool HasAnswer(const LabelledOutcome& labelled) {
  return std::ranges::any_of(labelled.outcome->scans, &ScanOutcome::answered);
}

// The picture of drive `i` for the page; its PNG is written beside.
absl::StatusOr<std::string> DriveSection(const Report& report, std::size_t i,
                                         const fs::path& html) {
  std::vector<LabelledOutcome> outcomes;
  for (const ReportRun& run : report.runs) outcomes.push_back({run.label, &run.outcomes[i]});
  const DriveOutcome& first = *outcomes.front().outcome;
  const std::string heading = absl::StrCat("<h2>", EscapeHtml(first.drive), "</h2>\n");
  if (std::ranges::none_of(outcomes, HasAnswer)) {
    return heading + "<p>No scan of this drive was answered with a pose.</p>\n";
  }
  const Picture picture = DrawDrive(outcomes, report.is_track);
  const fs::path png = PngPath(html, first.drive, report.runs.front().outcomes.size() == 1);
  if (absl::Status status = RenderPng(picture, png); !status.ok()) return status;
  const auto svg = RenderSvg(picture);
  if (!svg.ok()) return svg.status();
  return heading + InlineSvg(*svg);
}

}  // namespace

absl::Status WriteReport(const Report& report, const fs::path& html) {
  std::string body = absl::StrCat(Settings(report), "<p>", EscapeHtml(report.note), "</p>\n",
                                  SummaryTable(report));
  for (std::size_t i = 0; i < report.runs.front().outcomes.size(); ++i) {
    const auto section = DriveSection(report, i, html);
    if (!section.ok()) return section.status();
    body += *section;
  }
  std::ofstream file(html, std::ios::binary);
  file << HtmlPage(report.title, body);
  file.close();
  if (!file) return absl::UnavailableError(absl::StrCat(html.string(), ": cannot be written"));
  return absl::OkStatus();
}

}  // namespace dcloc
