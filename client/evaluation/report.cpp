#include "client/evaluation/report.h"

#include <algorithm>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "client/evaluation/drive_picture.h"
#include "client/evaluation/metrics_format.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStyle =
    "body{font:15px/1.5 sans-serif;max-width:1500px;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;margin:1em 0}"
    "td,th{padding:.25em .9em;border-bottom:1px solid #ddd;text-align:right}"
    "td:first-child,th:first-child{text-align:left}"
    "dl{display:grid;grid-template-columns:max-content auto;gap:.1em 1em}dd{margin:0}"
    "svg{width:100%;height:auto}";

std::string Escape(absl::string_view text) {
  return absl::StrReplaceAll(text,
                             {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}});
}

std::string Row(const std::vector<std::string>& cells, const char* tag) {
  std::string row = "<tr>";
  for (const std::string& cell : cells) {
    absl::StrAppend(&row, "<", tag, ">", Escape(cell), "</", tag, ">");
  }
  return row + "</tr>\n";
}

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
  const auto rows = MetricsRows(columns);
  std::string table = "<table>\n" + Row(rows.front(), "th");
  for (std::size_t i = 1; i < rows.size(); ++i) table += Row(rows[i], "td");
  return table + "</table>\n";
}

std::string Settings(const Report& report) {
  std::string list = "<dl>\n";
  for (const auto& [name, value] : report.settings) {
    absl::StrAppend(&list, "<dt>", Escape(name), "</dt><dd>", Escape(value), "</dd>\n");
  }
  return list + "</dl>\n";
}

// gnuplot's file begins with an XML declaration, which may only stand at a file's own beginning.
std::string InlineSvg(const std::string& svg) {
  const std::size_t begin = svg.find("<svg");
  return begin == std::string::npos ? svg : svg.substr(begin);
}

fs::path PngPath(const fs::path& html, const std::string& drive, bool is_only_one) {
  const std::string suffix = is_only_one ? "" : "-" + drive;
  return html.parent_path() / (html.stem().string() + suffix + ".png");
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
  const std::string heading = absl::StrCat("<h2>", Escape(first.drive), "</h2>\n");
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
  std::string page =
      absl::StrCat("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>",
                   Escape(report.title), "</title><style>", kStyle, "</style></head><body>\n<h1>",
                   Escape(report.title), "</h1>\n", Settings(report), "<p>", Escape(report.note),
                   "</p>\n", SummaryTable(report));
  for (std::size_t i = 0; i < report.runs.front().outcomes.size(); ++i) {
    const auto section = DriveSection(report, i, html);
    if (!section.ok()) return section.status();
    page += *section;
  }
  page += "</body></html>\n";
  std::ofstream file(html, std::ios::binary);
  file << page;
  file.close();
  if (!file) return absl::UnavailableError(absl::StrCat(html.string(), ": cannot be written"));
  return absl::OkStatus();
}

}  // namespace dcloc
