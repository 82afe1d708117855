#include "server/base/framed_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <span>
#include <string>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"

namespace dcloc::server {
namespace {

class FramedFileTest : public ::testing::Test {
 protected:
  void Write(int count) {
    for (int i = 0; i < count; ++i) AppendFramed(ScanMessage(i), &bytes_);
    path_ = folder_.Write("file", std::as_bytes(std::span(bytes_)));
  }

  TemporaryFolder folder_;
  std::string bytes_;
  std::filesystem::path path_;
};

TEST_F(FramedFileTest, GivesTheMessagesFromAnyPositionAndGoesAtTheEnd) {
  Write(3);
  {
    FramedReader reader(path_);
    ASSERT_TRUE(reader.Begin().ok());
    v1::Scan scan;
    ASSERT_TRUE(*reader.Next(&scan));
    const std::int64_t second = reader.position();
    ASSERT_TRUE(*reader.Next(&scan));
    ASSERT_TRUE(*reader.Next(&scan));
    EXPECT_EQ(scan.sequence_number(), 2);
    EXPECT_FALSE(*reader.Next(&scan));
    ASSERT_TRUE(reader.Begin(second).ok());
    ASSERT_TRUE(*reader.Next(&scan));
    EXPECT_EQ(scan.sequence_number(), 1);
  }
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(FramedFileTest, WhatIsCutOffOrNotThereIsDataLoss) {
  Write(1);
  std::filesystem::resize_file(path_, bytes_.size() - 1);
  FramedReader reader(path_);
  ASSERT_TRUE(reader.Begin().ok());
  v1::Scan scan;
  EXPECT_EQ(reader.Next(&scan).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(FramedReader(folder_.path() / "none").Begin().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace dcloc::server
