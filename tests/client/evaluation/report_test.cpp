#include "client/evaluation/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "client/evaluation/gnuplot.h"
#include "client/evaluation/runner.h"
#include "tests/client/datasets/temp_folder.h"
#include "tests/client/evaluation/simulated_drives.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

int Count(const std::string& text, const std::string& word) {
  int count = 0;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

Report MakeReport() {
  SimulatedDrives drives = SimulateDrives(0.04);
  drives.live_drive.name = "it's <live> & well_known";
  Report report{.title = "A <title>", .settings = {{"Seed", "1 & 2"}}, .note = "Note."};
  const auto map = MapOf(drives.map_drive);
  EvaluationOptions options;
  report.runs.push_back({"with", {*Evaluate(map, drives.live_drive, options)}});
  options.localizer.doppler_compensation = false;
  report.runs.push_back({"without", {*Evaluate(map, drives.live_drive, options)}});
  return report;
}

TEST(WriteReport, MakesASelfContainedPageWithPictures) {
  const TempFolder folder;
  const absl::Status status = WriteReport(MakeReport(), folder.path() / "report.html");
  ASSERT_TRUE(status.ok()) << status;
  const std::string page = ReadText(folder.path() / "report.html");
  EXPECT_THAT(page, StartsWith("<!DOCTYPE html>"));
  EXPECT_EQ(Count(page, "<svg"), 1);
  EXPECT_EQ(Count(page, "<?xml"), 0);
  EXPECT_THAT(page, HasSubstr("A &lt;title&gt;"));
  EXPECT_THAT(page, HasSubstr("it's &lt;live&gt; &amp; well_known, without</th>"));
  EXPECT_THAT(page, HasSubstr("<dt>Seed</dt><dd>1 &amp; 2</dd>"));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("<img")));
  EXPECT_THAT(ReadText(folder.path() / "report.png"), StartsWith("\x89PNG"));
}

TEST(WriteReport, NamesPicturesOfDrivesInFolders) {
  const TempFolder folder;
  Report report = MakeReport();
  for (ReportRun& run : report.runs) {
    run.outcomes.push_back(run.outcomes.front());
    run.outcomes.back().drive = "monday/north";
  }
  const absl::Status status = WriteReport(report, folder.path() / "report.html");
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_THAT(ReadText(folder.path() / "report-monday%2Fnorth.png"), StartsWith("\x89PNG"));
}

TEST(WriteReport, NamesThePicturesOfSeveralDrives) {
  const TempFolder folder;
  Report report = MakeReport();
  for (ReportRun& run : report.runs) {
    run.outcomes.push_back(run.outcomes.front());
    run.outcomes.front().drive = "one";
    run.outcomes.back().drive = "two";
  }
  ASSERT_TRUE(WriteReport(report, folder.path() / "report.html").ok());
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "report-one.png"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "report-two.png"));
  EXPECT_EQ(Count(ReadText(folder.path() / "report.html"), "<svg"), 2);
}

TEST(WriteReport, SaysThatADriveWasNeverAnswered) {
  const TempFolder folder;
  Report report = MakeReport();
  for (ReportRun& run : report.runs) {
    for (ScanOutcome& scan : run.outcomes.front().scans) {
      scan.answer.state = LocalizationState::kInitializing;
    }
  }
  const absl::Status status = WriteReport(report, folder.path() / "report.html");
  EXPECT_TRUE(status.ok()) << status;
  const std::string page = ReadText(folder.path() / "report.html");
  EXPECT_THAT(page, HasSubstr("No scan of this drive was answered with a pose"));
}

TEST(WriteReport, SaysWhereItCannotWrite) {
  const absl::Status status = WriteReport(MakeReport(), "/nonexistent/report.html");
  EXPECT_THAT(std::string(status.message()), HasSubstr("/nonexistent/report"));
}

TEST(Gnuplot, SaysWhatIsWrongWithAPicture) {
  const auto svg = RenderSvg({.commands = "plot no such thing"});
  EXPECT_EQ(svg.status().code(), absl::StatusCode::kInternal);
  EXPECT_THAT(std::string(svg.status().message()), HasSubstr("gnuplot failed"));
}

}  // namespace
}  // namespace dcloc
