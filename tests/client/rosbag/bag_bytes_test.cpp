#include "client/rosbag/bag_bytes.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>

namespace dcloc::rosbag {
namespace {

TEST(BagBytesTest, ValuesComeBackInTheirOrder) {
  const Stamp stamp(std::chrono::nanoseconds(1'700'000'000'123'456'789));
  std::string bytes;
  AppendTime(bytes, stamp);
  AppendText(bytes, "front");
  AppendNumber(bytes, -2.5);
  ByteReader reader(bytes);
  EXPECT_EQ(reader.TakeTime(), stamp);
  EXPECT_EQ(reader.TakeText(), "front");
  EXPECT_EQ(reader.Take<double>(), -2.5);
  EXPECT_TRUE(reader.ok());
  EXPECT_TRUE(reader.rest().empty());
}

TEST(BagBytesTest, BeyondTheEndEverythingIsZeroAndNotOk) {
  std::string bytes;
  AppendNumber(bytes, std::uint32_t{0xffffffff});  // the length of a text that is not there
  bytes += "abc";
  ByteReader reader(bytes);
  EXPECT_EQ(reader.TakeText(), "");
  EXPECT_FALSE(reader.ok());
  EXPECT_EQ(reader.Take<std::uint8_t>(), 0);  // though bytes are left
}

TEST(BagBytesTest, AHeadersFieldsMayHoldAnyBytes) {
  const HeaderFields fields = {{"op", std::string("\x05\0=", 3)}, {"topic", "/radar"}};
  const auto parsed = ParseHeader(FormatHeader(fields));
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_EQ(*parsed, fields);
}

TEST(BagBytesTest, ADamagedHeaderIsNamed) {
  std::string without_equals;
  AppendText(without_equals, "op");
  const std::string whole = FormatHeader({{"op", "x"}});
  for (const std::string& bytes : {without_equals, whole.substr(0, whole.size() - 1)}) {
    EXPECT_EQ(ParseHeader(bytes).status().code(), absl::StatusCode::kDataLoss);
  }
  const HeaderFields fields = {{"size", "1234"}};
  EXPECT_TRUE(NumberOf<std::uint32_t>(fields, "size").ok());
  EXPECT_EQ(NumberOf<std::uint64_t>(fields, "size").status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(NumberOf<std::uint32_t>(fields, "count").status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace dcloc::rosbag
