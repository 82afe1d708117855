#include "server/maps/jobs/scan_spool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "server/base/framed_file.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/messages.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

v1::StartMapBuildRequest SpoolScan(std::int64_t number) {
  v1::StartMapBuildRequest message;
  *message.mutable_scan()->mutable_scan() = ScanMessage(number);
  return message;
}

constexpr std::int64_t kMany = std::int64_t{1} << 30;

TEST(ScanSpoolTest, GivesTheMessagesInTheirOrderAndFromAnyPosition) {
  const TemporaryFolder folder;
  const auto spool = *ScanSpool::Create(folder.path());
  for (const int number : {3, 1, 2}) ASSERT_TRUE(spool->Append(SpoolScan(number), kMany).ok());
  EXPECT_EQ(spool->Finish()->size(), 64U);
  FramedReader reader(spool->path());
  v1::StartMapBuildRequest message;
  ASSERT_TRUE(reader.Begin().ok());
  ASSERT_TRUE(*reader.Next(&message));
  const std::int64_t second = reader.position();
  EXPECT_EQ(message.scan().scan().sequence_number(), 3);
  ASSERT_TRUE(*reader.Next(&message));
  ASSERT_TRUE(*reader.Next(&message));
  EXPECT_EQ(message.scan().scan().sequence_number(), 2);
  EXPECT_FALSE(*reader.Next(&message));
  ASSERT_TRUE(reader.Begin(second).ok());
  ASSERT_TRUE(*reader.Next(&message));
  EXPECT_EQ(message.scan().scan().sequence_number(), 1);
}

TEST(ScanSpoolTest, TheFileGoesWithItsOwner) {
  const TemporaryFolder folder;
  std::filesystem::path path;
  {
    const auto spool = *ScanSpool::Create(folder.path());
    path = spool->path();
    ASSERT_TRUE(spool->Append(SpoolScan(1), kMany).ok());
    EXPECT_TRUE(std::filesystem::exists(path));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(ScanSpoolTest, HasABound) {
  const TemporaryFolder folder;
  const auto spool = *ScanSpool::Create(folder.path());
  const absl::Status status = spool->Append(SpoolScan(1), 100);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(MessageOf(status), HasSubstr("max_map_mib"));
}

TEST(ScanSpoolTest, AFileThatIsCutOffIsNoWholeOne) {
  const TemporaryFolder folder;
  const auto spool = *ScanSpool::Create(folder.path());
  for (const int number : {1, 2}) ASSERT_TRUE(spool->Append(SpoolScan(number), kMany).ok());
  ASSERT_TRUE(spool->Finish().ok());
  std::filesystem::resize_file(spool->path(), std::filesystem::file_size(spool->path()) - 3);
  FramedReader reader(spool->path());
  v1::StartMapBuildRequest message;
  ASSERT_TRUE(reader.Begin().ok());
  ASSERT_TRUE(*reader.Next(&message));
  EXPECT_EQ(reader.Next(&message).status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace dcloc::server
