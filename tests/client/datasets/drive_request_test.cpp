#include "client/datasets/drive_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "client/datasets/radar_selection.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

TEST(DriveRequestTest, ADriveMayBeReadWholeOrInPart) {
  DriveRequest request;
  EXPECT_TRUE(Validate(request).ok());
  request.beta_s = 0.04;
  request.begin_s = 3.0;
  request.end_s = 4.0;
  EXPECT_TRUE(Validate(request).ok());
}

TEST(DriveRequestTest, ErrorsNameTheFieldAndItsBounds) {
  const auto error_of = [](auto DriveRequest::*field, double value) {
    DriveRequest request;
    request.*field = value;
    return std::string(Validate(request).message());
  };
  EXPECT_THAT(error_of(&DriveRequest::begin_s, -1.0), HasSubstr("begin_s is -1"));
  EXPECT_THAT(error_of(&DriveRequest::end_s, std::numeric_limits<double>::quiet_NaN()),
              HasSubstr("end_s is nan"));
  EXPECT_THAT(error_of(&DriveRequest::beta_s, 1.5),
              HasSubstr("beta_s is 1.5; it must lie in [-1, 1]"));
}

TEST(RadarSelectionTest, RadarsAreTakenFromThoseThatThereAre) {
  const std::vector<std::string> available = {"front", "left"};
  EXPECT_TRUE(CheckRadars({"left"}, available).ok());
  EXPECT_EQ(CheckRadars({"rear"}, available).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(CheckRadars({"left", "left"}, available).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(IsWanted({}, "left"));
  EXPECT_TRUE(IsWanted({"left"}, "left"));
  EXPECT_FALSE(IsWanted({"left"}, "front"));
}

}  // namespace
}  // namespace dcloc
