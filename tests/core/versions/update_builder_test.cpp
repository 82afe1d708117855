#include "core/versions/update_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/datasets/drive_map.h"
#include "client/datasets/whole_drives.h"
#include "client/simulation/simulation.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

/// A street that has aged, its map of before, and drives of three vehicles since.
class UpdateBuilderTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    SimulationOptions options;
    options.seed = 12;
    options.length_m = 300.0;
    options.vehicle_count = 4;
    options.ageing.replaced_share = 0.1;
    options.live_speeds_mps = {14.0, 11.0, 17.0};
    const std::vector<PassOptions> passes = Passes(options);
    const Drive before = SimulatePass(options, passes[0]).value();
    base_ = new EditableMap(
        ToEditable(*RadarMap::FromBytes(BuildMap(before, {.name = "base"}).value()).value()));
    drives_ = new std::vector<Drive>;
    for (std::size_t i = 1; i < passes.size(); ++i) {
      drives_->push_back(SimulatePass(options, passes[i]).value());
    }
  }
  static void TearDownTestSuite() {
    delete base_;
    delete drives_;
  }

  static absl::StatusOr<JudgedUpdate> Build(
      const std::vector<Drive>& drives,
      const UpdateProgress& progress = [](const std::string&, double) { return true; }) {
    WholeDrives source(drives);
    return BuildUpdate(*base_, {.source = source, .vehicles = {}, .held_out = 2}, {}, progress);
  }

  static inline EditableMap* base_ = nullptr;
  static inline std::vector<Drive>* drives_ = nullptr;
};

TEST_F(UpdateBuilderTest, AllButTheJudgeTakePart) {
  const auto update = Build(*drives_);
  ASSERT_TRUE(update.ok()) << update.status();
  ASSERT_EQ(update->passes.size(), 2U);
  EXPECT_NE(update->passes[0].vehicle, update->passes[1].vehicle);
  EXPECT_EQ(update->held_out, (*drives_)[2].name);
  EXPECT_EQ(update->faults, std::vector<std::string>(2));
  EXPECT_FALSE(update->gate.reason.empty());
  EXPECT_TRUE(update->passes[0].scans[0].points.empty());
  EXPECT_THAT(DescribeJudgement(*update), HasSubstr("judged by " + update->held_out + ": fit"));
}

TEST_F(UpdateBuilderTest, DrivesOfNoUseAreNamedWithTheReason) {
  std::vector<Drive> drives = *drives_;
  drives[0].scans.resize(20);
  const auto update = Build(drives);
  EXPECT_EQ(update.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(update.status().message()),
              HasSubstr("two drives must agree on a change, and 1 is of use. " + drives[0].name));
}

TEST_F(UpdateBuilderTest, CanBeEndedInEachStage) {
  for (const char* stage : {"localizing", "reading", "updating", "judging"}) {
    const auto update = Build(*drives_, [&](const std::string& now, double /*share*/) {
      return now.find(stage) == std::string::npos;
    });
    EXPECT_EQ(update.status().code(), absl::StatusCode::kCancelled) << stage;
  }
}

}  // namespace
}  // namespace dcloc
