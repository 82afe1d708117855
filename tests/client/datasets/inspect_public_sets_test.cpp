// `dcloc dataset inspect` says of each public data set what was found, and the mapping of bags.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "client/cli/dataset/inspect_run.h"
#include "tests/client/datasets/bag_set_writer.h"
#include "tests/client/datasets/body_frame.h"
#include "tests/client/datasets/hercules_writer.h"
#include "tests/client/datasets/temp_folder.h"
#include "tests/client/datasets/zod_writer.h"

namespace dcloc {
namespace {

using Json = nlohmann::json;

class InspectPublicSetsTest : public ::testing::Test {
 protected:
  /// What a user is told of the folder, whose format and only drive are found by themselves.
  Json Inspected() const {
    ::testing::internal::CaptureStdout();
    const absl::Status status = cli::RunInspect({.path = folder_.path().string(),
                                                 .dataset = {},
                                                 .drive = {},
                                                 .mapping_file = "",
                                                 .json = true});
    const std::string text = ::testing::internal::GetCapturedStdout();
    EXPECT_TRUE(status.ok()) << status;
    return Json::parse(text);
  }
  void ExpectFound(const char* dataset, const char* drive, const char* radar) const {
    const Json told = Inspected();
    EXPECT_EQ(told["dataset"], dataset);
    EXPECT_EQ(told["drive"]["poses"], "reference") << told["drive"];
    EXPECT_EQ(told["drive"]["radars"][0]["id"], radar);
    EXPECT_EQ(told["drive"]["radars"][0]["range_rates"], "away");
    EXPECT_EQ(told["drives"], Json::array({drive}));
  }
  void ExpectMapping(const char* topic) const {
    const Json told = Inspected();
    EXPECT_EQ(told["mapping_is_sound"], true);
    EXPECT_EQ(told["proposed_mapping"]["radars"][0]["topic"], topic);
    EXPECT_EQ(told["proposed_mapping"]["velocity_by_doppler"], true);
  }

  static const Drive& Drive1() {
    static const Drive drive = SimulateTwoPasses(/*seed=*/24).live;
    return drive;
  }

  const TempFolder folder_;
};

TEST_F(InspectPublicSetsTest, SnailRadar) {
  WriteBagSet(BagSet::kSnailRadar, Drive1(), folder_.path(), "20240123/data3");
  ExpectFound("snail-radar", "20240123/data3", "ars548");
  ExpectMapping("/ars548");
}

TEST_F(InspectPublicSetsTest, Ntu4dRadLm) {
  WriteBagSet(BagSet::kNtu4dRadLm, Drive1(), folder_.path(), "cp/cp_2022-02-26");
  ExpectFound("ntu4dradlm", "cp/cp_2022-02-26", "oculii");
  ExpectMapping("/radar_enhanced_pcl");
}

TEST_F(InspectPublicSetsTest, MscRad4r) {
  // Its radar has no place of its own: as if it were in the middle of the vehicle.
  WriteBagSet(BagSet::kMscRad4r, Drive1(), folder_.path(), "URBAN_A0");
  const Json told = Inspected();
  EXPECT_EQ(told["dataset"], "msc-rad4r");
  EXPECT_EQ(told["proposed_mapping"]["reference_topic"], "/fix");
  EXPECT_EQ(told["drive"]["radars"][0]["id"], "oculii");
}

TEST_F(InspectPublicSetsTest, Hercules) {
  WriteHercules(Drive1(), folder_.path(), "Mountain/Day2");
  ExpectFound("hercules", "Mountain/Day2", "continental");
}

TEST_F(InspectPublicSetsTest, Zod) {
  WriteZod({{"000002", &Drive1(), {0.0, 0.0, 0.0}}}, folder_.path());
  ExpectFound("zod", "000002", "front");
}

}  // namespace
}  // namespace dcloc
