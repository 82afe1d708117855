#include "client/trajectory/trajectory_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dcloc {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(TrajectoryFormatTest, TheNameDecidesAndElseTheExtension) {
  EXPECT_EQ(*TrajectoryFormatOf("run.tum", ""), TrajectoryFormat::kTum);
  EXPECT_EQ(*TrajectoryFormatOf("run.GPX", ""), TrajectoryFormat::kGpx);
  EXPECT_EQ(*TrajectoryFormatOf("run.json", ""), TrajectoryFormat::kGeoJson);
  EXPECT_EQ(*TrajectoryFormatOf("run.tum", "kitti"), TrajectoryFormat::kKitti);
  EXPECT_EQ(*TrajectoryFormatOf("run", "csv"), TrajectoryFormat::kCsv);
}

TEST(TrajectoryFormatTest, AnErrorNamesWhatWasWrittenAndWhatThereIs) {
  const auto message = [](const char* path, const char* name) {
    return std::string(TrajectoryFormatOf(path, name).status().message());
  };
  EXPECT_THAT(message("run.tum", "las"), AllOf(HasSubstr("'las'"), HasSubstr("geojson")));
  EXPECT_THAT(message("run.las", ""), AllOf(HasSubstr("run.las"), HasSubstr("tum")));
  EXPECT_THAT(message("run", ""), HasSubstr("run"));
}

TEST(TrajectoryFormatTest, FormatsOfTheEarthNeedAnAnchor) {
  for (const auto& [name, format] : kTrajectoryFormatNames) {
    const bool on_earth = std::string(name) == "geojson" || std::string(name) == "gpx";
    EXPECT_EQ(NeedsAnchor(format), on_earth) << name;
  }
}

}  // namespace
}  // namespace dcloc
