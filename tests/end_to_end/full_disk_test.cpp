#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "client/sdk/map_client.h"
#include "tests/core/map/synthetic_map.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/end_to_end/server_process.h"

// A disk that takes no more, as the server's process sees it.
namespace dcloc {
namespace {

constexpr std::uint64_t kRoom_bytes = 4 << 20;

class FullDiskTest : public ::testing::Test {
 protected:
  void Start(std::uint64_t max_file_bytes) {
    server_.reset();
    server_ = std::make_unique<ServerProcess>(
        DCLOC_SERVER_PROGRAM, folder_.path() / "store", folder_.path() / "log",
        ServerProcessOptions{.max_file_bytes = max_file_bytes});
    ASSERT_TRUE(server_->WaitUntilReady());
  }

  client::MapClient Maps() const { return client::MapClient(server_->Channel()); }

  std::filesystem::path MapFile(std::size_t keyframe_count) const {
    return folder_.Write(std::to_string(keyframe_count) + ".dclm",
                         SyntheticMap(keyframe_count, 300).Bytes());  // 13 kB each
  }

  const TemporaryFolder folder_;
  std::unique_ptr<ServerProcess> server_;
};

TEST_F(FullDiskTest, IsAnErrorToWhoSendsTooMuchAndToNobodyElse) {
  Start(kRoom_bytes);
  const std::filesystem::path small = MapFile(20);
  const std::filesystem::path big = MapFile(1000);
  ASSERT_TRUE(Maps().Upload(small, "town", {.activate = true}).ok());
  const absl::Status status = Maps().Upload(big, "city", {.activate = true}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(Maps().Get("city").status().code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(Maps().Download("town", 0, folder_.path() / "copy").ok());
  EXPECT_TRUE(Maps().Upload(MapFile(21), "town", {.activate = true}).ok());
  EXPECT_EQ(Maps().Upload(big, "city", {.activate = true}).status().code(),
            absl::StatusCode::kResourceExhausted);

  Start(0);
  std::int64_t first_sent_bytes = 0;
  const auto version = Maps().Upload(
      big, "city", {.activate = true, .progress = [&](std::int64_t sent, std::int64_t) {
                      if (first_sent_bytes == 0) first_sent_bytes = sent;
                    }});
  EXPECT_TRUE(version.ok()) << version.status();
  EXPECT_GT(first_sent_bytes, static_cast<std::int64_t>(kRoom_bytes) / 2)
      << "once there is room it goes on where it was";
  EXPECT_EQ(Maps().List()->size(), 2U);
}

}  // namespace
}  // namespace dcloc
