#include "server/maps/store/served_ages.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {
namespace {

using std::chrono::hours;
using Ages = std::map<std::string, ServedAges::Age>;

class ServedAgesTest : public ::testing::Test {
 protected:
  /// As a process of its own each time.
  Ages After(hours served, const std::map<std::string, std::int64_t>& sizes) {
    return ServedAges(path_).Advance(served, sizes).value_or(Ages{});
  }

  const TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "ages";
};

TEST_F(ServedAgesTest, TimeThatIsServedAddsUpOverRestarts) {
  EXPECT_EQ(After(hours(5), {{"a b", 1}}), (Ages{{"a b", hours(0)}}));
  EXPECT_EQ(After(hours(2), {{"a b", 1}, {"c", 2}}), (Ages{{"a b", hours(2)}, {"c", hours(0)}}));
  EXPECT_EQ(After(hours(0), {{"a b", 1}, {"c", 2}}), (Ages{{"a b", hours(2)}, {"c", hours(0)}}));
  EXPECT_EQ(After(hours(3), {{"a b", 1}, {"c", 2}}), (Ages{{"a b", hours(5)}, {"c", hours(3)}}));
}

TEST_F(ServedAgesTest, WhatChangesOrGoesBeginsAnew) {
  After(hours(1), {{"a", 1}, {"b", 1}, {"c", 1}});
  After(hours(1), {{"a", 2}, {"c", 1}});
  ASSERT_TRUE(ServedAges(path_).Forget("c").ok());
  EXPECT_EQ(After(hours(1), {{"a", 2}, {"b", 1}, {"c", 1}}),
            (Ages{{"a", hours(1)}, {"b", hours(0)}, {"c", hours(0)}}));
}

TEST_F(ServedAgesTest, FilesAreRemovedWhenTheyHaveBeenThereForLong) {
  const std::vector<std::filesystem::path> files = {folder_.path() / "old", folder_.path() / "new"};
  const auto remove_after = [&](hours served) {
    return ServedAges(path_).RemoveAged(served, hours(10), files).value_or(-1);
  };
  std::ofstream(files[0]) << "old";
  EXPECT_EQ(remove_after(hours(6)), 0);
  std::ofstream(files[1]) << "new";
  EXPECT_EQ(remove_after(hours(6)), 0);
  EXPECT_EQ(remove_after(hours(4)), 1);
  EXPECT_FALSE(std::filesystem::exists(files[0]));
  EXPECT_TRUE(std::filesystem::exists(files[1]));
}

TEST_F(ServedAgesTest, LostOrBrokenAgesBeginAnew) {
  After(hours(1), {{"a", 1}});
  After(hours(1), {{"a", 1}});
  std::ofstream(path_) << "-5 1 a\nnonsense";
  EXPECT_EQ(After(hours(1), {{"a", 1}}), (Ages{{"a", hours(0)}}));
}

}  // namespace
}  // namespace dcloc::server
