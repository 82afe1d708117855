#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "client/sdk/channel.h"
#include "client/sdk/map_client.h"
#include "server/app/server.h"
#include "tests/client/sdk/tcp_proxy.h"
#include "tests/core/map/synthetic_map.h"
#include "tests/core/map/temporary_folder.h"

// Map files on their way to a server and back, over a network that fails.
namespace dcloc::client {
namespace {

using ::testing::HasSubstr;

std::string ReadAll(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class MapTransferTest : public ::testing::Test {
 protected:
  MapTransferTest() {
    Start();
    proxy_ = std::make_unique<TcpProxy>(Port());
    maps_ = std::make_unique<MapClient>(*MakeChannel({.server = proxy_->address()}));
  }

  void Start() {
    auto server = server::Server::Start({.data = (folder_.path() / "data").string(),
                                         .listen = "127.0.0.1:0",
                                         .stub_localizer = true,
                                         .log_level = "error"});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  int Port() const {
    const std::string& address = server_->address();
    return std::stoi(address.substr(address.rfind(':') + 1));
  }

  const TemporaryFolder folder_;
  const std::filesystem::path file_ =
      folder_.Write("town.dclm", SyntheticMap(2000, 300).Bytes());  // 26 MB
  std::unique_ptr<server::Server> server_;
  std::unique_ptr<TcpProxy> proxy_;
  std::unique_ptr<MapClient> maps_;
};

TEST_F(MapTransferTest, AnUploadWhoseConnectionBreaksGoesOnByItself) {
  const auto size = static_cast<std::int64_t>(std::filesystem::file_size(file_));
  std::vector<std::int64_t> cuts = {2 * size / 3, size / 3};
  std::vector<std::int64_t> sent_after_cut;
  bool just_cut = false;
  const auto version = maps_->Upload(
      file_, "town", {.activate = true, .progress = [&](std::int64_t sent, std::int64_t total) {
                        EXPECT_EQ(total, size);
                        if (just_cut) sent_after_cut.push_back(sent);
                        just_cut = !cuts.empty() && sent >= cuts.back();
                        if (!just_cut) return;
                        cuts.pop_back();
                        proxy_->Cut();
                      }});
  ASSERT_TRUE(version.ok()) << version.status();
  EXPECT_EQ(version->size_bytes(), size);
  EXPECT_TRUE(cuts.empty());
  EXPECT_GE(proxy_->connection_count(), 3);
  const auto in_flight_at_most = size / 3;
  ASSERT_EQ(sent_after_cut.size(), 2U);
  EXPECT_GT(*std::ranges::max_element(sent_after_cut), in_flight_at_most)
      << "it did not begin anew";
}

TEST_F(MapTransferTest, AnUploadOutlivesTheServersRestart) {
  const auto size = static_cast<std::int64_t>(std::filesystem::file_size(file_));
  bool restarted = false;
  const auto version = maps_->Upload(
      file_, "town", {.activate = true, .progress = [&](std::int64_t sent, std::int64_t) {
                        if (restarted || sent < size / 2) return;
                        restarted = true;
                        server_.reset();
                        Start();
                        proxy_->SetTarget(Port());
                      }});
  ASSERT_TRUE(version.ok()) << version.status();
  EXPECT_TRUE(restarted);
  EXPECT_TRUE(maps_->Get("town").ok());
}

TEST_F(MapTransferTest, AnUploadGivesUpWhenNothingMovesAnyMore) {
  const auto size = static_cast<std::int64_t>(std::filesystem::file_size(file_));
  const auto version = maps_->Upload(file_, "town",
                                     {.give_up_after = std::chrono::milliseconds(300),
                                      .progress = [&](std::int64_t sent, std::int64_t) {
                                        if (sent >= size / 2) server_.reset();
                                      }});
  EXPECT_EQ(version.status().code(), absl::StatusCode::kUnavailable) << version.status();
}

TEST_F(MapTransferTest, AFileThatTheServerHasIsNotSentAgain) {
  ASSERT_TRUE(maps_->Upload(file_, "town", {.activate = true}).ok());
  std::int64_t sent_bytes = 0;
  const auto version = maps_->Upload(
      file_, "city",
      {.activate = true,
       .progress = [&](std::int64_t sent, std::int64_t /*size_bytes*/) { sent_bytes = sent; }});
  ASSERT_TRUE(version.ok()) << version.status();
  EXPECT_EQ(version->map_name(), "city");
  EXPECT_EQ(sent_bytes, 0);
}

TEST_F(MapTransferTest, ADownloadIsTheFileThatWasUploaded) {
  ASSERT_TRUE(maps_->Upload(file_, "town", {.activate = true}).ok());
  const std::filesystem::path copy = folder_.path() / "copy.dclm";
  std::int64_t done_bytes = 0;
  const auto version = maps_->Download("town", 0, copy, [&](std::int64_t done, std::int64_t size) {
    EXPECT_LE(done, size);
    done_bytes = done;
  });
  ASSERT_TRUE(version.ok()) << version.status();
  EXPECT_EQ(done_bytes, version->size_bytes());
  EXPECT_TRUE(ReadAll(copy) == ReadAll(file_));
}

TEST_F(MapTransferTest, ADownloadThatFailsLeavesNothingAndTouchesNoFile) {
  ASSERT_TRUE(maps_->Upload(file_, "town", {.activate = true}).ok());
  const std::filesystem::path copy = folder_.Write("copy.dclm", {});
  EXPECT_EQ(maps_->Download("city", 0, copy).status().code(), absl::StatusCode::kNotFound);
  const auto nowhere = maps_->Download("town", 0, folder_.path() / "no" / "copy.dclm").status();
  EXPECT_THAT(std::string(nowhere.message()), HasSubstr("copy.dclm"));
  const auto cut = maps_->Download("town", 0, copy, [&](std::int64_t done, std::int64_t size) {
    if (done > size / 3) proxy_->Cut();
  });
  EXPECT_EQ(cut.status().code(), absl::StatusCode::kUnavailable) << cut.status();
  EXPECT_EQ(std::filesystem::file_size(copy), 0U);
  EXPECT_FALSE(std::filesystem::exists(copy.string() + ".part"));
}

}  // namespace
}  // namespace dcloc::client
