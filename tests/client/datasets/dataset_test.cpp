#include "client/datasets/dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/datasets/export_bag.h"
#include "tests/client/datasets/temp_folder.h"
#include "tests/client/datasets/tiny_nuscenes.h"
#include "tests/client/datasets/two_radars.h"

namespace dcloc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(DatasetTest, AFolderTellsItsFormatAndItsDrives) {
  const TempFolder scenes;
  TinyNuScenes().WriteTo(scenes);
  EXPECT_EQ(*DetectFormat(scenes.path()), DatasetFormat::kNuScenes);
  const auto names = DriveNames({DatasetFormat::kNuScenes, scenes.path(), ""});
  ASSERT_TRUE(names.ok()) << names.status();
  EXPECT_THAT(*names, ::testing::Contains("scene-0001"));

  const TempFolder bags;
  EXPECT_THAT(DetectFormat(bags.path()).status().message(), HasSubstr(bags.path().string()));
  EXPECT_EQ(DriveNames({DatasetFormat::kRosbag, bags.path(), ""}).status().code(),
            absl::StatusCode::kNotFound);
  for (const char* name : {"b.bag", "a.bag"}) {
    ASSERT_TRUE(ExportBag(TwoRadars(), bags.path() / name, rosbag::Compression::kNone).ok());
  }
  EXPECT_EQ(*DetectFormat(bags.path()), DatasetFormat::kRosbag);
  EXPECT_THAT(*DriveNames({DatasetFormat::kRosbag, bags.path(), ""}), ElementsAre("a", "b"));

  const TempFolder sequences;
  sequences.Write("data/sensors.json", "{}");
  EXPECT_EQ(*DetectFormat(sequences.path()), DatasetFormat::kRadarScenes);
  EXPECT_EQ(DriveNames({DatasetFormat::kRadarScenes, sequences.path(), ""}).status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace dcloc
