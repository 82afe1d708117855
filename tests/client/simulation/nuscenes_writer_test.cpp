#include "client/simulation/nuscenes_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "client/datasets/nuscenes.h"
#include "client/simulation/radar_pcd_writer.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// A folder of this test's own, gone when it ends.
class NuScenesWriterTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    root_ = fs::path(::testing::TempDir()) / (std::string("dcloc_simulation_") + info->name());
    fs::remove_all(root_);
    options_.length_m = 60.0;
    options_.live_speeds_mps = {12.0};
    options_.rig_size = 5;
    options_.seed = 3;
  }
  void TearDown() override { fs::remove_all(root_); }

  std::vector<SimulatedPass> Write(const fs::path& root, const SimulationOptions& options) {
    auto writer = NuScenesWriter::Create(root, false);
    EXPECT_TRUE(writer.ok()) << writer.status();
    std::vector<SimulatedPass> passes;
    for (const PassOptions& pass : Passes(options)) {
      passes.push_back(*SimulatePassWithTruth(MakeWorld(options), options, pass));
      EXPECT_TRUE(writer->AddPass(passes.back()).ok());
    }
    EXPECT_TRUE(writer->Finish(options).ok());
    return passes;
  }

  static std::string Bytes(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }

  json Table(const std::string& name) const {
    return json::parse(Bytes(root_ / "v1.0-sim" / (name + ".json")));
  }

  static std::map<std::string, std::string> AllFiles(const fs::path& root) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      if (entry.is_regular_file()) {
        files[fs::relative(entry.path(), root).string()] = Bytes(entry.path());
      }
    }
    return files;
  }

  fs::path root_;
  SimulationOptions options_;
};

TEST_F(NuScenesWriterTest, TablesReferToOneAnother) {
  const std::vector<SimulatedPass> passes = Write(root_, options_);
  std::map<std::string, std::set<std::string>> tokens;
  for (const char* name :
       {"scene", "sample", "sample_data", "sensor", "calibrated_sensor", "ego_pose", "log", "map",
        "category", "attribute", "visibility", "instance", "sample_annotation"}) {
    for (const json& row : Table(name)) {
      EXPECT_EQ(row["token"].get<std::string>().size(), 32U);
      EXPECT_TRUE(tokens[name].insert(row["token"]).second) << name;
    }
  }
  const auto has = [&](const char* table, const json& token) {
    return tokens[table].contains(token.get<std::string>());
  };
  for (const json& scene : Table("scene")) {
    EXPECT_TRUE(has("log", scene["log_token"]));
    EXPECT_TRUE(has("sample", scene["first_sample_token"]));
    EXPECT_TRUE(has("sample", scene["last_sample_token"]));
  }
  for (const json& row : Table("calibrated_sensor")) {
    EXPECT_TRUE(has("sensor", row["sensor_token"]));
  }
  EXPECT_EQ(Table("sensor").size(), 5U);
  EXPECT_EQ(Table("map")[0]["log_tokens"].size(), passes.size());
  EXPECT_TRUE(fs::exists(root_ / Table("map")[0]["filename"].get<std::string>()));
  for (const json& row : Table("sample_data")) {
    EXPECT_TRUE(has("sample", row["sample_token"]));
    EXPECT_TRUE(has("ego_pose", row["ego_pose_token"]));
    EXPECT_TRUE(has("calibrated_sensor", row["calibrated_sensor_token"]));
    const auto filename = row["filename"].get<std::string>();
    EXPECT_TRUE(fs::exists(root_ / filename)) << filename;
    EXPECT_THAT(filename, StartsWith(row["is_key_frame"].get<bool>() ? "samples/" : "sweeps/"));
    EXPECT_THAT(filename, EndsWith(std::to_string(row["timestamp"].get<std::int64_t>()) + ".pcd"));
  }
}

TEST_F(NuScenesWriterTest, ChainsRunThroughEverySampleAndSweep) {
  const std::vector<SimulatedPass> passes = Write(root_, options_);
  std::map<std::string, json> samples;
  for (const json& row : Table("sample")) samples[row["token"]] = row;
  for (const json& scene : Table("scene")) {
    std::size_t count = 0;
    std::string token = scene["first_sample_token"];
    std::string last;
    while (!token.empty()) {
      ASSERT_TRUE(samples.contains(token));
      EXPECT_EQ(samples[token]["prev"], last);
      EXPECT_EQ(samples[token]["scene_token"], scene["token"]);
      last = token;
      token = samples[token]["next"];
      ++count;
    }
    EXPECT_EQ(count, scene["nbr_samples"]);
    EXPECT_EQ(last, scene["last_sample_token"]);
  }
  // Each sample has one key frame of each radar, near to it in time.
  std::map<std::pair<std::string, std::string>, int> key_frames;
  std::map<std::string, json> sweeps;
  for (const json& row : Table("sample_data")) {
    sweeps[row["token"]] = row;
    if (!row["is_key_frame"].get<bool>()) {
      // A sweep between two samples belongs to the later one.
      const json& sample = samples[row["sample_token"]];
      const auto ahead =
          sample["timestamp"].get<std::int64_t>() - row["timestamp"].get<std::int64_t>();
      EXPECT_LT(ahead, 500'000);
      EXPECT_TRUE(ahead >= 0 || sample["next"] == json(""));
      continue;
    }
    ++key_frames[{row["sample_token"], row["calibrated_sensor_token"]}];
    const auto distance = row["timestamp"].get<std::int64_t>() -
                          samples[row["sample_token"]]["timestamp"].get<std::int64_t>();
    EXPECT_LE(std::abs(distance), 90'000);
  }
  EXPECT_EQ(key_frames.size(), 5 * samples.size());
  for (const auto& [key, count] : key_frames) EXPECT_EQ(count, 1);
  std::size_t heads = 0;
  std::size_t reached = 0;
  for (const auto& [token, row] : sweeps) {
    if (!row["prev"].get<std::string>().empty()) continue;
    ++heads;
    for (std::string at = token; !at.empty(); at = sweeps[at]["next"]) {
      ++reached;
      const std::string next = sweeps[at]["next"];
      if (next.empty()) continue;
      EXPECT_EQ(sweeps[next]["prev"], at);
      EXPECT_LT(sweeps[at]["timestamp"], sweeps[next]["timestamp"]);
      EXPECT_EQ(sweeps[at]["calibrated_sensor_token"], sweeps[next]["calibrated_sensor_token"]);
    }
  }
  EXPECT_EQ(heads, 5 * passes.size());
  EXPECT_EQ(reached, sweeps.size());
}

// What was simulated, written, and read by the reader of recordings is the same drive.
void ExpectSameDrive(const Drive& written, const Drive& read) {
  EXPECT_EQ(read.name, written.name);
  EXPECT_EQ(read.place, written.place);
  ASSERT_EQ(read.rig.radars.size(), written.rig.radars.size());
  for (const RadarModel& radar : written.rig.radars) {
    const RadarModel* other = read.rig.Find(radar.id);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(other->beta_s, radar.beta_s);
    EXPECT_EQ(other->range_sigma_m, radar.range_sigma_m);
    EXPECT_EQ(other->azimuth_sigma_rad, radar.azimuth_sigma_rad);
    EXPECT_EQ(other->has_elevation, radar.has_elevation);
    EXPECT_LT(Log(other->T_vehicle_radar.Inverse() * radar.T_vehicle_radar).norm(), 1e-12);
  }
  ASSERT_EQ(read.scans.size(), written.scans.size());
  for (std::size_t i = 0; i < read.scans.size(); ++i) {
    const DriveScan& a = written.scans[i];
    const DriveScan& b = read.scans[i];
    EXPECT_EQ(b.scan.stamp, a.scan.stamp);
    EXPECT_EQ(b.scan.radar_id, a.scan.radar_id);
    EXPECT_LT(Log(b.T_map_vehicle.Inverse() * a.T_map_vehicle).norm(), 1e-9);
    ASSERT_TRUE(b.scan.ego_velocity.has_value());
    EXPECT_LT((b.scan.ego_velocity->linear_mps - a.scan.ego_velocity->linear_mps).norm(), 1e-9);
    EXPECT_LT((b.scan.ego_velocity->angular_radps - a.scan.ego_velocity->angular_radps).norm(),
              1e-9);
    ASSERT_EQ(b.scan.size(), a.scan.size());
    ASSERT_EQ(b.scan.elevation_rad.size(), a.scan.elevation_rad.size());
    for (std::size_t k = 0; k < a.scan.size(); ++k) {
      EXPECT_NEAR(b.scan.range_m[k], a.scan.range_m[k], 1e-4F);
      EXPECT_NEAR(WrapAngle(b.scan.azimuth_rad[k] - a.scan.azimuth_rad[k]), 0.0, 1e-5);
      EXPECT_NEAR(b.scan.range_rate_mps[k], a.scan.range_rate_mps[k], 1e-4F);
      EXPECT_EQ(b.scan.rcs_dbsm[k], a.scan.rcs_dbsm[k]);
    }
    for (std::size_t k = 0; k < a.scan.elevation_rad.size(); ++k) {
      EXPECT_NEAR(b.scan.elevation_rad[k], a.scan.elevation_rad[k], 1e-5F);
    }
  }
}

TEST_F(NuScenesWriterTest, OurReaderReadsTheSameDrive) {
  for (const SimulatedPass& pass : Write(root_, options_)) {
    const auto read = ReadNuScenesDrive(root_, {pass.drive.name, {}, {}});
    ASSERT_TRUE(read.ok()) << read.status();
    ExpectSameDrive(pass.drive, *read);
  }
}

TEST_F(NuScenesWriterTest, OurReaderReadsEachVehiclesRig) {
  options_.vehicle_count = 2;
  for (const SimulatedPass& pass : Write(root_, options_)) {
    const auto read = ReadNuScenesDrive(root_, {pass.drive.name, {}, {}});
    ASSERT_TRUE(read.ok()) << read.status();
    ExpectSameDrive(pass.drive, *read);
  }
  EXPECT_EQ(Table("log")[0]["vehicle"], "sim");
  EXPECT_EQ(Table("log")[1]["vehicle"], "sim-1");
}

TEST_F(NuScenesWriterTest, WhatChangedLiesBesideTheTables) {
  options_.ageing = {.replaced_share = 0.2, .post_count = 4};
  auto writer = NuScenesWriter::Create(root_, false);
  ASSERT_TRUE(writer.ok());
  const simulation::AgedWorld aged = AgeWorld(MakeWorld(options_), options_);
  const auto pass = SimulatePassWithTruth(aged.world, options_, Passes(options_)[1]);
  ASSERT_TRUE(writer->AddPass(*pass).ok());
  ASSERT_TRUE(writer->AddChanges(aged.changes).ok());
  ASSERT_TRUE(writer->Finish(options_).ok());
  const json changes = Table("dcloc_changes");
  EXPECT_EQ(changes["scatterers"].size(), aged.changes.size());
  EXPECT_EQ(changes["scatterers"].back()["cause"], "posts");
  EXPECT_EQ(changes["parked"]["live-0"].size(), pass->parked.size());
  EXPECT_EQ(Table("dcloc_rig")["simulation"]["ageing"]["post_count"], 4);
  // It goes with the simulation that it belongs to.
  ASSERT_TRUE(NuScenesWriter::Create(root_, false).ok());
  EXPECT_FALSE(fs::exists(root_ / "v1.0-sim" / kChangesFileName));
}

TEST_F(NuScenesWriterTest, OurReaderReadsElevations) {
  options_.has_elevation = true;
  options_.radar = RadarKind::kCarla;
  options_.rig_size = 1;
  for (const SimulatedPass& pass : Write(root_, options_)) {
    const auto read = ReadNuScenesDrive(root_, {pass.drive.name, {}, {}});
    ASSERT_TRUE(read.ok()) << read.status();
    ExpectSameDrive(pass.drive, *read);
  }
}

TEST_F(NuScenesWriterTest, EqualSeedsGiveEqualBytes) {
  options_.rig_size = 1;
  Write(root_ / "a", options_);
  Write(root_ / "b", options_);
  options_.seed = 4;
  Write(root_ / "c", options_);
  const auto a = AllFiles(root_ / "a");
  EXPECT_GT(a.size(), 50U);
  EXPECT_EQ(a, AllFiles(root_ / "b"));
  EXPECT_NE(a, AllFiles(root_ / "c"));
}

TEST_F(NuScenesWriterTest, ReplacesAnEarlierSimulationAndNothingElse) {
  options_.rig_size = 1;
  Write(root_, options_);
  const std::size_t before = AllFiles(root_).size();
  options_.length_m = 50.0;
  Write(root_, options_);  // no left-overs of the longer one
  EXPECT_LT(AllFiles(root_).size(), before);

  std::ofstream(root_ / "thesis.tex") << "mine";
  const auto refused = NuScenesWriter::Create(root_, false);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr(root_.string()));
  EXPECT_TRUE(NuScenesWriter::Create(root_, true).ok());
  EXPECT_EQ(Bytes(root_ / "thesis.tex"), "mine");
}

TEST_F(NuScenesWriterTest, FixesLieBesideThePassAndGoWithIt) {
  options_.rig_size = 1;
  Write(root_, options_);
  auto writer = NuScenesWriter::Create(root_, false);
  ASSERT_TRUE(writer.ok()) << writer.status();
  const std::vector<StampedFix> fixes = {
      {Stamp(std::chrono::seconds(1)), MapFix{.horizontal_sigma_m = 1.0, .vertical_sigma_m = 2.0}}};
  ASSERT_TRUE(writer->AddFixes("live-0", fixes).ok());
  ASSERT_TRUE(writer->Finish(options_).ok());
  EXPECT_EQ(ReadFixes(root_ / kFixFolder / "live-0.csv")->size(), 1U);
  ASSERT_TRUE(NuScenesWriter::Create(root_, false).ok()) << "it is an earlier simulation";
  EXPECT_FALSE(fs::exists(root_ / kFixFolder));
}

TEST_F(NuScenesWriterTest, SaysWhatItCannotWrite) {
  fs::create_directories(root_);
  std::ofstream(root_ / "file") << "x";
  const auto writer = NuScenesWriter::Create(root_ / "file", false);
  EXPECT_FALSE(writer.ok());
  EXPECT_THAT(std::string(writer.status().message()), HasSubstr("file"));
}

TEST(RadarPcdTest, HasTheOfficialLayout) {
  RadarModel radar;
  radar.id = "RADAR_FRONT";
  Scan scan;
  scan.radar_id = radar.id;
  scan.range_m = {10.0F, 20.0F};
  scan.range_rate_mps = {-5.0F, 3.0F};
  scan.azimuth_rad = {0.0F, 0.5F};
  scan.rcs_dbsm = {7.5F, -2.0F};
  scan.ego_velocity.emplace();
  scan.ego_velocity->linear_mps.x() = 5.0;
  const std::string bytes = EncodeRadarPcd(scan, radar);
  const std::size_t data = bytes.find("DATA binary\n") + 12;
  EXPECT_EQ(bytes.size() - data, 2 * 43U + 1);
  EXPECT_THAT(bytes, HasSubstr("\nPOINTS 2\n"));
  const auto number = [&](std::size_t row, std::size_t offset) {
    float value = 0.0F;
    std::memcpy(&value, bytes.data() + data + 43 * row + offset, 4);
    return value;
  };
  EXPECT_FLOAT_EQ(number(0, 0), 10.0F);    // x
  EXPECT_FLOAT_EQ(number(0, 19), -5.0F);   // vx
  EXPECT_NEAR(number(0, 27), 0.0F, 1e-6);  // vx_comp
  EXPECT_EQ(bytes[data + 12], 1);          // dyn_prop: stands still
  EXPECT_FLOAT_EQ(number(1, 4), 20.0F * std::sin(0.5F));
  EXPECT_FLOAT_EQ(number(1, 15), -2.0F);  // rcs
  EXPECT_EQ(bytes[data + 43 + 12], 0);    // moves
}

TEST(RadarPcdTest, AnEmptyScanIsOneRowOfNan) {
  const std::string bytes = EncodeRadarPcd(Scan{}, RadarModel{});
  const std::size_t data = bytes.find("DATA binary\n") + 12;
  ASSERT_EQ(bytes.size() - data, 43U + 1);
  float x = 0.0F;
  std::memcpy(&x, bytes.data() + data, 4);
  EXPECT_TRUE(std::isnan(x));
}

}  // namespace
}  // namespace dcloc
