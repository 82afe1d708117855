// Text files with a stamp and numbers a line.
#include "client/datasets/files/stamped_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::array kColumns = {"a", "b"};

class StampedRowsTest : public ::testing::Test {
 protected:
  auto Read(const std::string& text, StampUnit unit = StampUnit::kNanoseconds) const {
    return ReadStampedRows(folder_.Write("rows.txt", text), unit, kColumns);
  }
  std::string Error(const std::string& text) const {
    const absl::Status status = Read(text).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
    return std::string(status.message());
  }
  const TempFolder folder_;
};

TEST_F(StampedRowsTest, BlanksAndCommasSeparate) {
  const auto rows = Read("stamp,a,b\n# a remark\n\n1,2.5,3,9\r\n2 4\t5\n");
  ASSERT_TRUE(rows.ok()) << rows.status();
  ASSERT_EQ(rows->size(), 2U);
  EXPECT_THAT((*rows)[0].values, ElementsAre(2.5, 3.0));
  EXPECT_THAT((*rows)[1].values, ElementsAre(4.0, 5.0));
  const auto seconds = Read("1706001762.429354169 1 2\n", StampUnit::kSeconds);
  EXPECT_EQ(seconds->at(0).stamp.time_since_epoch().count(), 1'706'001'762'429'354'169);
}

TEST_F(StampedRowsTest, WhatIsBrokenIsNamed) {
  EXPECT_THAT(Error("1 2 3\n2 4"),
              HasSubstr("rows.txt: line 2: has 2 values; at least 3 are needed"));
  EXPECT_THAT(Error("1 2 x\n"), HasSubstr("line 1: b is 'x'; it must be a number"));
  EXPECT_THAT(Error("1 inf 2\n"), HasSubstr("line 1: a is 'inf'"));
  EXPECT_THAT(Error("1.5 2 3\n"), HasSubstr("line 1: the stamp is '1.5'"));
  EXPECT_THAT(Error("2 2 3\n1 2 3\n"),
              HasSubstr("line 2: the stamp is 1 ns; it must be after 2 ns"));
  EXPECT_THAT(Error("2 2 3\n2 2 3\n"),
              HasSubstr("line 2: the stamp is 2 ns; it must be after 2 ns"));
}

TEST_F(StampedRowsTest, PosesHaveARotation) {
  const auto poses =
      ReadStampedPoses(folder_.Write("a", "1 1 2 3 0 0 0 1\n"), StampUnit::kNanoseconds);
  ASSERT_TRUE(poses.ok()) << poses.status();
  EXPECT_EQ(poses->at(0).pose.translation_m, Eigen::Vector3d(1.0, 2.0, 3.0));
  const auto none =
      ReadStampedPoses(folder_.Write("a", "1 1 2 3 0 0 0 2\n"), StampUnit::kNanoseconds);
  EXPECT_THAT(std::string(none.status().message()),
              HasSubstr("the quaternion's norm is 2; it must be 1"));
  EXPECT_EQ(ReadStampedPoses(folder_.path() / "none", StampUnit::kSeconds).status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace dcloc
