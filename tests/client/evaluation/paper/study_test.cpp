#include "client/evaluation/paper/study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <utility>

#include "client/cli/evaluate/result_folder.h"
#include "client/evaluation/paper/outcome_json.h"
#include "client/evaluation/paper/simulated_cases.h"
#include "core/calibration/calibration.h"
#include "tests/client/datasets/temp_folder.h"
#include "tests/client/evaluation/simulated_drives.h"

namespace dcloc::paper {
namespace {

using ::testing::HasSubstr;

using RunFolder = cli::ResultFolder<DriveOutcome>;

class MemoryStore final : public ResultStore<DriveOutcome> {
 public:
  std::optional<DriveOutcome> Load(const std::string& name) override {
    const auto found = runs.find(name);
    return found == runs.end() ? std::nullopt : std::optional(found->second);
  }
  absl::Status Save(const std::string& name, const DriveOutcome& outcome) override {
    saved.push_back(name);
    runs[name] = outcome;
    return absl::OkStatus();
  }

  std::map<std::string, DriveOutcome> runs;
  std::vector<std::string> saved;
};

const auto kQuiet = [](const std::string&, double) {};

// A few seconds of a simulated street, and how often it was asked for.
class Study : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    drives_ = new SimulatedDrives(SimulateDrives());
    drives_->live_drive.scans.resize(30);
  }
  static void TearDownTestSuite() { delete drives_; }

  Case MakeCase(bool is_calibrated = false) {
    Case item{.set = "street", .name = "street-1", .purpose = Purpose::kNoise};
    item.load = [this]() -> absl::StatusOr<DrivePair> {
      ++load_count_;
      return DrivePair{drives_->map_drive, drives_->live_drive};
    };
    if (is_calibrated) {
      // Described so wrongly that there is something to correct.
      item.load_calibration = []() -> absl::StatusOr<std::vector<Drive>> {
        Drive drive = drives_->map_drive;
        for (RadarModel& radar : drive.rig.radars) {
          radar = Corrected(radar, CalibrationParameter::kMountYaw, 0.03);
        }
        return std::vector<Drive>{std::move(drive)};
      };
    }
    return item;
  }

  static SimulatedDrives* drives_;
  int load_count_ = 0;
};

SimulatedDrives* Study::drives_ = nullptr;

TEST_F(Study, DoesEachRunOnceAndKnowsItsSpeedDifferences) {
  MemoryStore store;
  const auto results = RunStudy({MakeCase()}, false, store, kQuiet);
  ASSERT_TRUE(results.ok()) << results.status();
  ASSERT_EQ(results->size(), NoiseRows().size() - 1);  // no drive to calibrate on
  EXPECT_EQ(load_count_, 1);
  EXPECT_EQ(store.saved.size(), results->size());
  for (const RunResult& result : *results) {
    EXPECT_EQ(result.set, "street");
    EXPECT_EQ(result.outcome.scans.size(), 30U);
    EXPECT_EQ(result.outcome.map, nullptr);
    for (const ScanOutcome& scan : result.outcome.scans) {
      EXPECT_TRUE(scan.speed_difference_mps.has_value());
    }
  }
}

TEST_F(Study, GoesOnWhereItWas) {
  MemoryStore store;
  ASSERT_TRUE(RunStudy({MakeCase()}, false, store, kQuiet).ok());
  const auto first = store.runs;
  store.saved.clear();
  load_count_ = 0;
  ASSERT_TRUE(RunStudy({MakeCase()}, false, store, kQuiet).ok());
  EXPECT_EQ(load_count_, 0) << "drives are loaded for nothing";
  EXPECT_TRUE(store.saved.empty());

  store.runs.erase("street-1.dc-loc.track");
  ASSERT_TRUE(RunStudy({MakeCase()}, false, store, kQuiet).ok());
  EXPECT_EQ(store.saved, std::vector<std::string>{"street-1.dc-loc.track"});
  const auto& again = store.runs.at("street-1.dc-loc.track").scans;
  const auto& before = first.at("street-1.dc-loc.track").scans;
  ASSERT_EQ(again.size(), before.size());
  for (std::size_t i = 0; i < again.size(); ++i) {
    EXPECT_EQ(again[i].error.translation_m, before[i].error.translation_m);
  }
}

TEST_F(Study, DoesOverWhatItsFilesDoNotHoldWhole) {
  const TempFolder folder;
  RunFolder runs({folder.path(), "build"}, OutcomeFromJson, OutcomeToJson);
  ASSERT_TRUE(RunStudy({MakeCase()}, false, runs, kQuiet).ok());
  const auto file = folder.path() / "street-1.dcloc.track.json";
  const auto size = std::filesystem::file_size(file);
  std::filesystem::resize_file(file, size / 2);
  // What a write that was cut off leaves behind.
  folder.Write("street-1.dc-loc.track.json.AbCdEf", "{\"outc");
  EXPECT_FALSE(runs.Load("street-1.dcloc.track").has_value());
  load_count_ = 0;
  const auto results = RunStudy({MakeCase()}, false, runs, kQuiet);
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_EQ(load_count_, 1);
  EXPECT_TRUE(runs.Load("street-1.dcloc.track").has_value());

  RunFolder other_build({folder.path(), "another build"}, OutcomeFromJson, OutcomeToJson);
  EXPECT_FALSE(other_build.Load("street-1.dcloc.track").has_value());
}

TEST_F(Study, TellsTheCalibratedRigToTheCalibratedRunsAlone) {
  MemoryStore store;
  const auto results = RunStudy({MakeCase(true)}, false, store, kQuiet);
  ASSERT_TRUE(results.ok()) << results.status();
  ASSERT_EQ(results->size(), NoiseRows().size());
  const DriveOutcome& described = store.runs.at("street-1.dcloc.track");
  const DriveOutcome& calibrated = store.runs.at("street-1.dcloc-calibrated.track");
  EXPECT_NE(described.scans.back().error.translation_m,
            calibrated.scans.back().error.translation_m);
  EXPECT_LT(calibrated.scans.back().error.translation_m, 0.5);
}

TEST_F(Study, RunsNothingTwiceWhereThereIsNothingToCompensate) {
  Case item = MakeCase();
  item.purpose = Purpose::kMethods;
  item.query_interval_s = 100.0;
  MemoryStore store;
  const auto results = RunStudy({item}, false, store, kQuiet);
  ASSERT_TRUE(results.ok()) << results.status();
  const auto error = [&](const char* name) {
    return store.runs.at(name).scans.back().error.translation_m;
  };
  EXPECT_EQ(error("street-1.icp.track"), error("street-1.icp-nodoppler.track"));
  std::set<std::string> names(store.saved.begin(), store.saved.end());
  EXPECT_EQ(names.size(), store.saved.size()) << "a run was done twice";
}

TEST_F(Study, NamesTheRunThatFails) {
  Case item = MakeCase();
  item.load = []() -> absl::StatusOr<DrivePair> { return absl::DataLossError("a.pcd: broken"); };
  MemoryStore store;
  const auto results = RunStudy({item}, false, store, kQuiet);
  EXPECT_EQ(results.status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(results.status().message()), HasSubstr("street-1.icp.track: a.pcd"));
}

TEST(PlanRuns, HasEveryTableOfThePaperForAnAblationCaseAndNoRunTwice) {
  Case item{.name = "case", .purpose = Purpose::kAblations};
  item.load_calibration = [] { return std::vector<Drive>{}; };
  std::set<std::string> names;
  const std::vector<paper::Run> runs = PlanRuns(item, false);
  for (const paper::Run& run : runs) EXPECT_TRUE(names.insert(RunName(item, run)).second);
  for (const RowPlan& row : Table1Rows()) {
    EXPECT_TRUE(names.contains(RunName(item, {row.variant, Protocol::kTrack})));
    EXPECT_TRUE(names.contains(RunName(item, {row.variant, Protocol::kPairs})));
  }
  for (const MethodKind method : {MethodKind::kDcLocPlusPlus, MethodKind::kDcloc}) {
    EXPECT_EQ(Table2Rows(method).size(), 8U);
    for (const RowPlan& row : Table2Rows(method)) {
      EXPECT_TRUE(names.contains(RunName(item, {row.variant, Protocol::kTrack}))) << row.label;
    }
  }
  for (const int scans : {1, 3, 5, 8, 10, 13, 15}) {
    EXPECT_TRUE(names.contains(RunName(item, {{.scans_per_submap = scans}, Protocol::kTrack})))
        << scans;
  }
  EXPECT_TRUE(names.contains("case.dcloc-calibrated-far.pairs"));
  item.load_calibration = nullptr;
  for (const paper::Run& run : PlanRuns(item, false)) EXPECT_FALSE(run.variant.calibrated);
}

TEST(SimulatedCases, AreNamedApartAndDrivenAtAllSpeedsWithEachNoise) {
  std::set<std::string> names;
  std::map<std::string, int> counts;
  for (const Case& item : SimulatedCases(false)) {
    EXPECT_TRUE(names.insert(item.name).second) << item.name;
    EXPECT_TRUE(static_cast<bool>(item.load_calibration)) << item.name;
    ++counts[item.set];
  }
  for (const char* noise : {"gaussian", "gamma", "student", "rayleigh"}) {
    EXPECT_EQ(counts[std::string("noise ") + noise], 4);
    for (const char* speed : {"20kmh", "40kmh", "60kmh", "100kmh"}) {
      EXPECT_TRUE(names.contains(std::string("sim-carla-town-") + noise + "-seed51-" + speed));
    }
  }
  EXPECT_EQ(counts["simulated ARS408, town"], 8);
}

}  // namespace
}  // namespace dcloc::paper
