#include "core/mapping/survey_checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/mapping/drive_tracker.h"
#include "core/mapping/survey.h"
#include "tests/core/mapping/ring_road.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

class MemoryStore final : public SurveyCheckpointStore {
 public:
  const std::string& name() const override { return name_; }
  absl::StatusOr<std::vector<std::byte>> Read() override { return bytes; }
  absl::Status Write(std::span<const std::byte> written) override {
    bytes.assign(written.begin(), written.end());
    ++write_count;
    return absl::OkStatus();
  }

  std::vector<std::byte> bytes;
  int write_count = 0;

 private:
  const std::string name_ = "store";
};

DriveTrack TrackAround(const std::string& name, double begin_m, double length_m, unsigned seed) {
  DriveTracker tracker(name, FrontRadar(), {});
  for (const RingScan& entry : ScansOnRing(RingRoad(2), begin_m, length_m, 12.0, seed)) {
    EXPECT_TRUE(tracker.Add(entry.scan).ok());
  }
  return tracker.Finish();
}

/// What is known of where the nodes are, of a survey that is stopped at the `stage`-th change of
/// the stage; of all of it if there is none.
absl::StatusOr<Survey> SurveyUntil(int stage, std::span<const DriveTrack> tracks,
                                   SurveyCheckpointStore* store,
                                   std::vector<std::string>* stages = nullptr) {
  std::string last;
  int count = 0;
  return SurveyDrives(
      tracks, {}, {},
      [&](const char* name, double) {
        if (last != name) {
          ++count;
          last = name;
          if (stages != nullptr) stages->push_back(name);
        }
        return count != stage;
      },
      store);
}

class SurveyCheckpointTest : public ::testing::Test {
 protected:
  const std::vector<DriveTrack> tracks_ = {TrackAround("a", 0.0, 620.0, 2),
                                           TrackAround("b", 300.0, 250.0, 3)};
};

TEST_F(SurveyCheckpointTest, ASurveyThatWasStoppedGoesOnAndEndsTheSame) {
  const absl::StatusOr<Survey> whole = SurveyUntil(-1, tracks_, nullptr);
  ASSERT_TRUE(whole.ok()) << whole.status();
  for (int stage = 2; stage <= 4; ++stage) {
    MemoryStore store;
    EXPECT_EQ(SurveyUntil(stage, tracks_, &store).status().code(), absl::StatusCode::kCancelled);
    ASSERT_GT(store.write_count, 0) << stage;
    std::vector<std::string> stages;
    const absl::StatusOr<Survey> rest = SurveyUntil(-1, tracks_, &store, &stages);
    ASSERT_TRUE(rest.ok()) << rest.status();
    EXPECT_THAT(stages, ::testing::Not(::testing::Contains("tying neighbours"))) << stage;
    ASSERT_EQ(rest->loops.size(), whole->loops.size());
    for (std::size_t drive = 0; drive < tracks_.size(); ++drive) {
      const SurveyedDrive& a = rest->drives[drive];
      const SurveyedDrive& b = whole->drives[drive];
      EXPECT_EQ(a.is_in_map, b.is_in_map);
      EXPECT_EQ(a.neighbour_count, b.neighbour_count);
      ASSERT_EQ(a.T_map_nodes.size(), b.T_map_nodes.size());
      for (std::size_t i = 0; i < a.T_map_nodes.size(); ++i) {
        EXPECT_EQ(a.T_map_nodes[i].translation_m, b.T_map_nodes[i].translation_m);
        EXPECT_EQ(a.T_map_nodes[i].yaw_rad, b.T_map_nodes[i].yaw_rad);
        EXPECT_EQ(a.T_start_nodes[i].translation_m, b.T_start_nodes[i].translation_m);
      }
    }
  }
}

TEST_F(SurveyCheckpointTest, OneOfOtherDrivesIsRefused) {
  MemoryStore store;
  ASSERT_FALSE(SurveyUntil(2, tracks_, &store).ok());
  const std::vector<DriveTrack> others = {tracks_[0], TrackAround("b", 300.0, 250.0, 4)};
  const std::vector<std::byte> before = store.bytes;
  const absl::Status status = SurveyUntil(-1, others, &store).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("store: the checkpoint is of other drives"));
  EXPECT_EQ(store.bytes, before);
}

TEST_F(SurveyCheckpointTest, EachChangedByteAndEachCutIsNoticed) {
  MemoryStore store;
  ASSERT_FALSE(SurveyUntil(2, tracks_, &store).ok());
  const std::vector<std::byte> good = store.bytes;
  for (std::size_t i = 0; i < good.size(); i += 1 + i / 50) {
    store.bytes = good;
    store.bytes[i] ^= std::byte{4};
    EXPECT_FALSE(SurveyUntil(-1, tracks_, &store).ok()) << i;
    store.bytes.assign(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_EQ(SurveyUntil(-1, tracks_, &store).ok(), i == 0) << i;  // an empty one is none
  }
}

TEST_F(SurveyCheckpointTest, NodesThatAreNotThereAreRefused) {
  SurveyCheckpoint checkpoint;
  checkpoint.finished_stage_count = 1;
  checkpoint.T_map_nodes.resize(3);
  checkpoint.T_start_nodes.resize(3);
  checkpoint.neighbours.emplace_back();
  checkpoint.neighbours[0].to = 3;
  constexpr std::uint32_t kInput = 7;
  const auto read = CheckpointFromBytes(ToBytes(checkpoint, kInput), kInput, 3, 1);
  EXPECT_EQ(read.status().code(), absl::StatusCode::kDataLoss) << read.status();
  checkpoint.neighbours[0].to = 2;
  checkpoint.findings = {"nothing"};
  const auto good = CheckpointFromBytes(ToBytes(checkpoint, kInput), kInput, 3, 1);
  ASSERT_TRUE(good.ok()) << good.status();
  EXPECT_EQ(good->neighbours[0].to, 2U);
  EXPECT_EQ(good->findings, checkpoint.findings);
  EXPECT_FALSE(CheckpointFromBytes(ToBytes(checkpoint, kInput), kInput, 4, 1).ok());
}

}  // namespace
}  // namespace dcloc
