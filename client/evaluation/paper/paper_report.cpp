#include "client/evaluation/paper/paper_report.h"

#include <optional>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/evaluation/gnuplot.h"
#include "client/evaluation/html.h"
#include "client/evaluation/paper/figures.h"
#include "client/evaluation/paper/goals.h"
#include "client/evaluation/paper/tables.h"

namespace dcloc::paper {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTitle = "The evaluation of DC-Loc++, repeated";

constexpr const char* kReading =
    "Success is a translation error below 2 m and a rotation error below 5 degrees. \"Where all "
    "succeed\" is the paper's selection: scans on which every row of the table succeeded; \"all\" "
    "is over every scan that the method answered, and success counts the others as failures. "
    "ANEES is 1 for an honest covariance, and absent for methods that know none. A misleading "
    "answer claims to track, is more than 2 m off, and outside of its 99.9 % ellipsoid. The slope "
    "is that of the translation error against the absolute difference between live and map speed. "
    "The paper's numbers are of other data (nuScenes revisits, CARLA drives): compare within a "
    "column before comparing between columns. Every method has the same prior, 1 m and 2 degrees "
    "off, and the same scans. ICP and NDT register every 0.2 s in a session and are carried by "
    "ego-motion between. Without a range-Doppler coupling (beta 0), what is not compensated is the "
    "same as what is, and not run twice. Times are one core's own.";

constexpr const char* kNoises =
    "Table IV's noises of range [m], angles [deg] and range rate [m/s], as they are read here: "
    "Gaussian of deviations 0.25, 0.5, 0.1; Gamma(0, .), which no law is, as exponential of "
    "deviations 0.25, 0.025, 0.1 with its mean taken off; Student's t with 100 degrees of freedom "
    "times 0.25, 0.5, 0.1; Rayleigh of scales 0.5, 1, 0.1 as printed, which biases all that is "
    "measured by 1.25 times its scale.";

constexpr const char* kGoals =
    "What is asked of dcloc: with the noises of Table IV and in the ARS408-like town at 20 to 100 "
    "km/h in a map made at 72 km/h; half of the best other's median error on every set; no trend "
    "of the error with the speed difference (the 95 % interval of the slope holds 0); 99.9 % of "
    "the answered scans right, none misleading; covariances that fit; on recordings, calibrated on "
    "other data, half of what a point-to-line ICP reached. \"Calibrated\" is told the rig as the "
    "calibrator finds it on the map drive, or on other recordings of the vehicle. The other "
    "methods "
    "are told the rig as described.";

std::string Heading(int level, const std::string& text) {
  return absl::StrFormat("<h%d>%s</h%d>\n", level, EscapeHtml(text), level);
}

// The figure for the page; its PNG goes beside. Nothing for a figure that there is no data for.
absl::StatusOr<std::string> Figure(const std::optional<Picture>& picture, const fs::path& png) {
  if (!picture) return std::string();
  if (absl::Status status = RenderPng(*picture, png); !status.ok()) return status;
  const auto svg = RenderSvg(*picture);
  if (!svg.ok()) return svg.status();
  return InlineSvg(*svg);
}

/// The page, section by section; the first failure stays.
class Page {
 public:
  explicit Page(fs::path folder) : folder_(std::move(folder)) {}

  void Add(const std::string& html) { body_ += html; }

  void AddFigure(const std::optional<Picture>& picture, const std::string& name) {
    if (!status_.ok()) return;
    const auto figure = Figure(picture, folder_ / (name + ".png"));
    if (figure.ok()) {
      body_ += *figure;
    } else {
      status_ = figure.status();
    }
  }

  void AddTables(const std::vector<StudyTable>& tables, const std::string& id,
                 const std::string& set) {
    for (const StudyTable& table : tables) {
      if (table.id != id || (!set.empty() && table.set != set)) continue;
      body_ += Heading(3, absl::StrCat(table.heading, ": ", table.set));
      body_ += HtmlTable(ComparisonText(table.rows));
    }
  }

  absl::StatusOr<std::string> Finish() const {
    if (!status_.ok()) return status_;
    return HtmlPage(kTitle, body_);
  }

 private:
  fs::path folder_;
  std::string body_;
  absl::Status status_;
};

std::string Settings(const std::vector<std::pair<std::string, std::string>>& settings) {
  std::string list = "<dl>\n";
  for (const auto& [name, value] : settings) {
    absl::StrAppend(&list, "<dt>", EscapeHtml(name), "</dt><dd>", EscapeHtml(value), "</dd>\n");
  }
  return list + "</dl>\n";
}

}  // namespace

nlohmann::ordered_json StudyJson(std::span<const RunResult> results) {
  nlohmann::ordered_json tables = nlohmann::ordered_json::array();
  const std::vector<StudyTable> tables_of_results = StudyTables(results);
  for (const StudyTable& table : tables_of_results) tables.push_back(ToJson(table));
  return {{"tables", std::move(tables)},
          {"goals", GoalsJson(Goals(results, tables_of_results))},
          {"paper_table_5_ms",
           {{"compensation", kCompensation_ms},
            {"registration", kRegistration_ms},
            {"pose_graph", kPoseGraph_ms},
            {"total", kTotal_ms}}}};
}

absl::StatusOr<std::string> StudyHtml(
    std::span<const RunResult> results,
    const std::vector<std::pair<std::string, std::string>>& settings, const fs::path& folder) {
  const std::vector<StudyTable> tables = StudyTables(results);
  Page page(folder);
  page.Add(Settings(settings));
  page.Add(absl::StrCat("<p>", EscapeHtml(kReading), "</p>\n"));
  page.Add(Heading(2, "Ours and the best of the others") + HtmlTable(SummaryText(tables)));
  page.Add(Heading(2, "Goals") + absl::StrCat("<p>", EscapeHtml(kGoals), "</p>\n") +
           HtmlTable(GoalsText(Goals(results, tables))));
  int number = 0;
  for (const std::string& set : SetsOf(results)) {
    if (absl::StartsWith(set, "noise ")) continue;
    ++number;
    page.Add(Heading(2, set));
    page.AddTables(tables, "table-1", set);
    page.AddFigure(DrawSpeedFigure(results, set), absl::StrCat("figure-9-set-", number));
    page.AddFigure(DrawDistributionFigure(results, set), absl::StrCat("figure-10-set-", number));
    page.AddFigure(DrawTrackFigure(results, set), absl::StrCat("figure-12-set-", number));
  }
  page.Add(Heading(2, "Table II: without parts of the method"));
  page.AddTables(tables, "table-2", "");
  page.Add(Heading(2, "Table III: scans in a sub-map"));
  page.AddTables(tables, "table-3", "");
  page.Add(Heading(2, "Table IV and Fig. 11: noise models") +
           absl::StrCat("<p>", EscapeHtml(kNoises), "</p>\n") +
           HtmlTable(NoiseReductionText(tables)));
  page.AddFigure(DrawNoiseFigure(results), "figure-11");
  page.AddTables(tables, "table-4", "");
  page.Add(Heading(2, "Table V: mean time by module") + HtmlTable(TimesText(tables)));
  return page.Finish();
}

}  // namespace dcloc::paper
