#include "client/datasets/whole_drives.h"

#include <gtest/gtest.h>

#include <vector>

namespace dcloc {
namespace {

TEST(WholeDrivesTest, EachCanBeReadSeveralTimes) {
  std::vector<Drive> drives(2);
  drives[1].name = "second";
  drives[1].scans.resize(3);
  drives[1].scans[2].scan.radar_id = "last";
  WholeDrives source(drives);
  ASSERT_EQ(source.drive_count(), 2U);
  for (int time = 0; time < 2; ++time) {
    const auto reader = source.Open(1).value();
    EXPECT_EQ(reader->name(), "second");
    EXPECT_EQ(reader->scan_count(), 3U);
    EXPECT_NE(reader->Next().value(), nullptr);
    EXPECT_NE(reader->Next().value(), nullptr);
    EXPECT_EQ(reader->Next().value()->radar_id, "last");
    EXPECT_EQ(reader->Next().value(), nullptr);
  }
}

}  // namespace
}  // namespace dcloc
