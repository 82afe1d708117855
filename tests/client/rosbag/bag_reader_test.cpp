// What bag_writer writes, bag_reader reads.
#include "client/rosbag/bag_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/rosbag/bag_bytes.h"
#include "client/rosbag/bag_writer.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc::rosbag {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr Stamp kBagStart{std::chrono::seconds(1'700'000'000)};

class BagReaderTest : public ::testing::Test {
 protected:
  void Write(Compression compression) const {
    auto bag = BagWriter::Create(path_, compression);
    ASSERT_TRUE(bag.ok()) << bag.status();
    ASSERT_TRUE(bag->Add("/tf", kTf2, kBagStart, "first").ok());
    ASSERT_TRUE(bag->Add("/radar", kPointCloud2, kBagStart + std::chrono::seconds(1), "").ok());
    ASSERT_TRUE(bag->Add("/tf", kTf2, kBagStart + std::chrono::seconds(2), "last").ok());
    const absl::Status status = bag->Close();
    ASSERT_TRUE(status.ok()) << status;
  }

  absl::StatusOr<BagSummary> Read() {
    return ReadBag(path_, [this](const Message& message) {
      const auto seconds = (message.record_time - kBagStart) / std::chrono::seconds(1);
      read_.push_back(absl::StrCat(message.connection.topic, " ", message.connection.type, " ",
                                   seconds, " ", message.data));
      return absl::OkStatus();
    });
  }

  const TempFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "drive.bag";
  std::vector<std::string> read_;
};

TEST_F(BagReaderTest, MessagesComeBackInTheirOrder) {
  for (const Compression compression : {Compression::kNone, Compression::kBz2, Compression::kLz4}) {
    Write(compression);
    read_.clear();
    const auto summary = Read();
    ASSERT_TRUE(summary.ok()) << summary.status();
    EXPECT_THAT(read_,
                ElementsAre("/tf tf2_msgs/TFMessage 0 first", "/radar sensor_msgs/PointCloud2 1 ",
                            "/tf tf2_msgs/TFMessage 2 last"));
    EXPECT_TRUE(summary->has_index);
    EXPECT_FALSE(summary->is_cut());
    EXPECT_EQ(summary->message_count, 3);
    EXPECT_THAT(summary->compressions, ElementsAre(std::string(NameOf(compression))));
  }
}

/// What a bag of one chunk has before the chunk's length, that length, and what follows.
struct OneChunk {
  std::string before;
  std::string length;
  std::string packed;
};
OneChunk Split(const std::string& bag) {
  // Behind the magic and the bag's header, which rosbag pads to 4096 bytes.
  const std::size_t chunk = kBagMagic.size() + 4096;
  std::uint32_t header_size = 0;
  std::memcpy(&header_size, bag.data() + chunk, sizeof(header_size));
  const std::size_t length = chunk + sizeof(header_size) + header_size;
  return {bag.substr(0, length), bag.substr(length, 4), bag.substr(length + 4)};
}

TEST_F(BagReaderTest, AChunkThatIsCutOffKeepsItsWholeMessages) {
  for (const Compression compression : {Compression::kNone, Compression::kLz4}) {
    auto bag = BagWriter::Create(path_, compression);
    ASSERT_TRUE(bag.ok()) << bag.status();
    std::mt19937 random(1);
    std::string data(200, ' ');
    for (int i = 0; i < 2000; ++i) {
      std::ranges::generate(data, [&] { return static_cast<char>('a' + random() % 26); });
      ASSERT_TRUE(bag->Add("/tf", kTf2, kBagStart, data).ok());
    }
    ASSERT_TRUE(bag->Close().ok());
    std::ifstream file(path_, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(file), {}};
    const OneChunk parts = Split(whole);
    const std::string half = parts.packed.substr(0, parts.packed.size() / 2);
    // A recorder that lost its power has not written how long the chunk is.
    for (const std::string& length : {parts.length, std::string(4, '\0')}) {
      std::ofstream(path_, std::ios::binary) << parts.before << length << half;
      read_.clear();
      const auto summary = Read();
      ASSERT_TRUE(summary.ok()) << summary.status();
      EXPECT_TRUE(summary->is_cut());
      EXPECT_GT(read_.size(), 600U) << NameOf(compression);
      EXPECT_LT(read_.size(), 1500U) << NameOf(compression);
    }
  }
}

TEST_F(BagReaderTest, AVisitorsErrorEndsTheReading) {
  Write(Compression::kNone);
  int count = 0;
  const auto summary = ReadBag(path_, [&](const Message&) {
    ++count;
    return absl::CancelledError("enough");
  });
  EXPECT_EQ(summary.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(count, 1);
}

TEST_F(BagReaderTest, WhatIsNoBagIsNamed) {
  EXPECT_EQ(Read().status().code(), absl::StatusCode::kNotFound);
  std::ofstream(path_) << "SQLite format 3";
  EXPECT_EQ(Read().status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(Read().status().message()), HasSubstr("drive.bag"));
}

TEST_F(BagReaderTest, AStampThatABagCannotHoldIsRefused) {
  auto bag = BagWriter::Create(path_, Compression::kNone);
  ASSERT_TRUE(bag.ok()) << bag.status();
  EXPECT_EQ(bag->Add("/tf", kTf2, Stamp(std::chrono::seconds(-1)), "").code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(bag->Add("/tf", kTf2, Stamp(std::chrono::seconds(1LL << 32)), "").code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace dcloc::rosbag
