#include "server/maps/jobs/pass_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kDay_ns = 86'400'000'000'000;
constexpr std::int64_t kMib = std::int64_t{1} << 20;

PassRow Row(const std::string& vehicle, std::int64_t day, std::int64_t scan_count,
            std::int64_t size_bytes = kMib) {
  PassRow row;
  row.vehicle = vehicle;
  row.scan_count = scan_count;
  row.size_bytes = size_bytes;
  row.first_stamp_ns = day * kDay_ns;
  row.create_time = SystemTime(std::chrono::hours(24 * day));
  return row;
}

SystemTime Day(int day) { return SystemTime(std::chrono::hours(24 * day)); }

TEST(PassChoiceTest, TheLongestJudgesAndItsWitnessTakesNoPart) {
  const auto choice = ChoosePasses(
      {Row("c", 9, 300), Row("b", 9, 500), Row("b", 9, 100), Row("a", 9, 200), Row("b", 8, 50)},
      Day(0), 100 * kMib);
  ASSERT_TRUE(choice.ok()) << choice.status();
  ASSERT_EQ(choice->passes.size(), 4U);
  EXPECT_EQ(choice->held_out, 3U);
  EXPECT_EQ(choice->passes[3].scan_count, 500);
  EXPECT_EQ(choice->passes[2].scan_count, 50) << "another day is another witness";
}

TEST(PassChoiceTest, PassesFromBeforeTheVersionAndBeyondTheBoundAreLeftOut) {
  const auto choice = ChoosePasses(
      {Row("c", 9, 300), Row("b", 9, 500), Row("a", 9, 200), Row("d", 2, 900)}, Day(5), 100 * kMib);
  ASSERT_TRUE(choice.ok()) << choice.status();
  EXPECT_EQ(choice->passes.size(), 3U);
  const auto few =
      ChoosePasses({Row("c", 9, 300), Row("b", 9, 500), Row("a", 9, 200)}, Day(5), 2 * kMib);
  EXPECT_EQ(few.status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(PassChoiceTest, SaysHowManyThereAre) {
  const auto choice =
      ChoosePasses({Row("a", 9, 300), Row("a", 9, 500), Row("b", 9, 1)}, Day(0), 100 * kMib);
  EXPECT_EQ(choice.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(
      std::string(choice.status().message()),
      HasSubstr("needs passes of 3 vehicles or days; since the version was made 3 passes of "
                "2 were kept"));
  EXPECT_FALSE(ChoosePasses({}, Day(0), kMib).ok());
}

}  // namespace
}  // namespace dcloc::server
