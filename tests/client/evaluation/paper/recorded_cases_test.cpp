#include "client/evaluation/paper/recorded_cases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "client/evaluation/paper/speed_difference.h"
#include "client/simulation/nuscenes_writer.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc::paper {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

// Two passes of one street in the official layout: the second revisits the first.
class RecordedCasesTest : public ::testing::Test {
 protected:
  static constexpr double kMapSpeed_mps = 7.0;
  static constexpr double kLiveSpeed_mps = 11.0;

  static void SetUpTestSuite() {
    options_ = new SimulationOptions;
    options_->length_m = 80.0;
    options_->rig_size = 5;
    options_->seed = 7;
    options_->map_speed_mps = kMapSpeed_mps;
    options_->live_speeds_mps = {kLiveSpeed_mps};
    passes_ = new std::vector<SimulatedPass>;
    folder_ = new TempFolder;
    auto writer = NuScenesWriter::Create(folder_->path() / "data" / "sim", false);
    ASSERT_TRUE(writer.ok()) << writer.status();
    for (const PassOptions& pass : Passes(*options_)) {
      passes_->push_back(*SimulatePassWithTruth(MakeWorld(*options_), *options_, pass));
      ASSERT_TRUE(writer->AddPass(passes_->back()).ok());
    }
    ASSERT_TRUE(writer->Finish(*options_).ok());
    fs::copy(Tables(), folder_->path() / "tables");
  }
  static void TearDownTestSuite() {
    delete folder_;
    delete passes_;
    delete options_;
  }

  // Each test has the tables as they were written.
  void SetUp() override {
    fs::copy(folder_->path() / "tables", Tables(), fs::copy_options::overwrite_existing);
  }

  static fs::path Tables() { return Data() / "sim" / "v1.0-sim"; }
  static fs::path Data() { return folder_->path() / "data"; }

  fs::path Table(const std::string& name) const { return Tables() / (name + ".json"); }

  void Edit(const std::string& name, const std::function<void(json&)>& edit) const {
    std::ifstream in(Table(name));
    json table = json::parse(in);
    edit(table);
    std::ofstream(Table(name)) << table.dump();
  }

  // The wheels' speed at the scan's moment, which poses have no part in.
  static double WheelSpeed(const SimulatedPass& pass, Stamp stamp) {
    const auto next = std::ranges::lower_bound(pass.signals, stamp, {}, &VehicleSignal::stamp);
    return next == pass.signals.end() ? pass.signals.back().speed_mps : next->speed_mps;
  }

  static SimulationOptions* options_;
  static std::vector<SimulatedPass>* passes_;
  static TempFolder* folder_;
};

SimulationOptions* RecordedCasesTest::options_ = nullptr;
std::vector<SimulatedPass>* RecordedCasesTest::passes_ = nullptr;
TempFolder* RecordedCasesTest::folder_ = nullptr;

TEST_F(RecordedCasesTest, FindsTheRevisitAndLocalizesItsFrontRadarOnly) {
  const auto cases = RecordedCases(Data());
  ASSERT_TRUE(cases.ok()) << cases.status();
  ASSERT_EQ(cases->size(), 1U);
  EXPECT_EQ(cases->front().set, "nuScenes, revisits");
  EXPECT_THAT(cases->front().name, HasSubstr("live-0-in-map"));
  EXPECT_EQ(cases->front().purpose, Purpose::kAblations);

  const auto drives = cases->front().load();
  ASSERT_TRUE(drives.ok()) << drives.status();
  EXPECT_EQ(drives->map.name, "map");
  EXPECT_EQ(drives->live.name, "live-0");
  for (const Drive* drive : {&drives->map, &drives->live}) {
    ASSERT_EQ(drive->rig.radars.size(), 1U);
    EXPECT_EQ(drive->rig.radars[0].id, "RADAR_FRONT");
  }
  // The street is one, so almost all of the drive revisits the other.
  std::size_t front_count = 0;
  for (const DriveScan& entry : (*passes_)[1].drive.scans) {
    if (entry.scan.radar_id == "RADAR_FRONT") ++front_count;
  }
  EXPECT_GT(drives->live.scans.size(), front_count * 8 / 10);
  for (const DriveScan& entry : drives->live.scans) {
    double nearest_m = 1e9;
    for (const DriveScan& other : (*passes_)[0].drive.scans) {
      nearest_m =
          std::min(nearest_m,
                   (other.T_map_vehicle.translation_m - entry.T_map_vehicle.translation_m).norm());
    }
    EXPECT_LT(nearest_m, 5.0 + kLiveSpeed_mps);  // a second's way before the first pair
  }
}

TEST_F(RecordedCasesTest, HasTheSpeedDifferencesOfTheWheels) {
  const auto drives = RecordedCases(Data())->front().load();
  ASSERT_TRUE(drives.ok()) << drives.status();
  const SpeedDifferences differences(drives->map, drives->live);
  std::map<int, int> bins;
  std::size_t near_count = 0;
  for (const DriveScan& entry : drives->live.scans) {
    const auto nearest =
        std::ranges::min_element((*passes_)[0].drive.scans, {}, [&](const DriveScan& other) {
          return (other.T_map_vehicle.translation_m - entry.T_map_vehicle.translation_m).norm();
        });
    const double wheels_mps = WheelSpeed((*passes_)[1], entry.scan.stamp) -
                              WheelSpeed((*passes_)[0], nearest->scan.stamp);
    const auto found = differences.At(entry.scan.stamp);
    ASSERT_TRUE(found.has_value());
    if (std::abs(*found - wheels_mps) < 0.5) ++near_count;
    ++bins[static_cast<int>(std::abs(*found) / 2.0)];
  }
  // But for the ends of the drives, where half a second around a scan is less.
  EXPECT_GT(near_count, drives->live.scans.size() * 9 / 10);
  EXPECT_GE(bins.size(), 2U);
}

TEST_F(RecordedCasesTest, FallsBackToOtherRadarsWhereNoSceneRevisitsAnother) {
  Edit("log", [](json& table) { table[1]["location"] = "another-town"; });
  const auto cases = RecordedCases(Data());
  ASSERT_TRUE(cases.ok()) << cases.status();
  ASSERT_EQ(cases->size(), 2U);
  for (const Case& item : *cases) EXPECT_EQ(item.set, "nuScenes, front map and rear radars");
  const auto drives = cases->front().load();
  ASSERT_TRUE(drives.ok()) << drives.status();
  EXPECT_EQ(drives->map.rig.radars.size(), 3U);
  EXPECT_NE(drives->map.rig.Find("RADAR_FRONT"), nullptr);
  EXPECT_EQ(drives->live.rig.radars.size(), 2U);
  EXPECT_NE(drives->live.rig.Find("RADAR_BACK_LEFT"), nullptr);
  // Calibrated on the vehicle's other scene with all radars, never on its own.
  ASSERT_TRUE(static_cast<bool>(cases->front().load_calibration));
  const auto others = cases->front().load_calibration();
  ASSERT_TRUE(others.ok()) << others.status();
  ASSERT_EQ(others->size(), 1U);
  EXPECT_NE(others->front().name, drives->live.name);
  EXPECT_EQ(others->front().rig.radars.size(), 5U);
}

TEST_F(RecordedCasesTest, CalibratesOnNoOtherVehicle) {
  Edit("log", [](json& table) {
    table[1]["location"] = "another-town";
    table[1]["vehicle"] = "another-car";
  });
  const auto cases = RecordedCases(Data());
  ASSERT_TRUE(cases.ok()) << cases.status();
  for (const Case& item : *cases) EXPECT_FALSE(static_cast<bool>(item.load_calibration));
}

TEST_F(RecordedCasesTest, NamesTheFileAndTheFieldThatAreBroken) {
  struct Damage {
    const char* table;
    std::function<void(json&)> edit;
    const char* field;
  };
  const std::vector<Damage> damages = {
      {"log", [](json& t) { t[0].erase("location"); }, "location"},
      {"log", [](json& t) { t[0]["vehicle"] = 7; }, "vehicle"},
      {"scene", [](json& t) { t[1]["log_token"] = "nobody"; }, "log_token"},
      {"sample", [](json& t) { t[3].erase("scene_token"); }, "scene_token"},
      {"sample_data", [](json& t) { t[0]["timestamp"] = "noon"; }, "timestamp"},
      {"sample_data",
       [](json& t) {
         for (json& row : t) row["sample_token"] = "none";
       },
       "sample_token"},
      {"ego_pose",
       [](json& t) {
         t[0]["rotation"] = {1.0, 0.0};
       },
       "rotation"},
      {"ego_pose", [](json& t) { t.erase(t.begin(), std::next(t.begin(), std::ssize(t) / 2)); },
       "RADAR_FRONT"},
  };
  for (const Damage& damage : damages) {
    json original;
    Edit(damage.table, [&](json& table) {
      original = table;
      // What is not looked at may be as it likes: put a front radar's row first.
      for (std::size_t i = 0; i < table.size(); ++i) {
        const std::string text = table[i].dump();
        if (text.find("samples/RADAR_FRONT/") == std::string::npos) continue;
        std::swap(table[0], table[i]);
        break;
      }
      if (std::string(damage.table) == "ego_pose") {
        std::ifstream in(Table("sample_data"));
        for (const json& row : json::parse(in)) {
          if (row["filename"].get<std::string>().find("samples/RADAR_FRONT/") == std::string::npos)
            continue;
          for (std::size_t i = 0; i < table.size(); ++i) {
            if (table[i]["token"] == row["ego_pose_token"]) std::swap(table[0], table[i]);
          }
          break;
        }
      }
      damage.edit(table);
    });
    const auto cases = RecordedCases(Data());
    EXPECT_FALSE(cases.ok()) << damage.table << " " << damage.field;
    const std::string message(cases.status().message());
    EXPECT_THAT(message, HasSubstr(std::string(damage.table) + ".json"));
    EXPECT_THAT(message, HasSubstr(damage.field));
    Edit(damage.table, [&](json& table) { table = original; });
  }
  EXPECT_TRUE(RecordedCases(Data()).ok());
}

TEST_F(RecordedCasesTest, NamesATableThatIsCutOffOrMissing) {
  fs::resize_file(Table("scene"), fs::file_size(Table("scene")) / 2);
  EXPECT_THAT(std::string(RecordedCases(Data()).status().message()), HasSubstr("scene.json"));
  fs::remove(Table("scene"));
  EXPECT_THAT(std::string(RecordedCases(Data()).status().message()), HasSubstr("scene.json"));
}

TEST(RecordedCases, SaysWhatIsMissingInAFolderWithoutRecordings) {
  const TempFolder folder;
  const auto cases = RecordedCases(folder.path());
  EXPECT_EQ(cases.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(cases.status().message()), HasSubstr("v1.0-*"));
}

}  // namespace
}  // namespace dcloc::paper
