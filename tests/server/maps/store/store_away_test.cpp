#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/maps/catalogue/sqlite_build_queue.h"
#include "server/maps/catalogue/sqlite_catalogue.h"
#include "server/maps/store/kept_files.h"
#include "server/maps/store/map_bucket.h"
#include "server/maps/store/map_scrub.h"
#include "server/maps/store/map_store.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/s3_stub.h"
#include "tests/server/fixtures/test_maps.h"

// A map store whose files are in an object store that comes and goes.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class StoreAwayTest : public ::testing::Test {
 protected:
  StoreAwayTest() { Open(); }

  void Open() {
    store_.reset();
    store_ =
        *MapStore::Open({.catalogue = *SqliteCatalogue::Open(folder_.path() / "catalogue.sqlite"),
                         .files = std::make_unique<MapBucket>(*ObjectStore::Open(stub_.Options())),
                         .incoming = *IncomingFiles::Open(folder_.path() / "incoming"),
                         .builds = *SqliteBuildQueue::Open(folder_.path() / "jobs.sqlite"),
                         .build_inputs = *KeptFolder::Open(folder_.path() / "builds"),
                         .holder = "host:1"},
                        {.max_warm_bytes = 0});
  }

  absl::Status Add(const std::string& map_name, const std::vector<std::byte>& bytes) {
    const auto path = folder_.Write(map_name, bytes);
    const auto map = *RadarMap::FromBytes(bytes);
    return store_->Add(path, map_name, Sha256Of(bytes), map).status();
  }

  void Return() {
    stub_.Start();
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
  }

  const std::vector<std::byte> bytes_ = SmallMap();
  TemporaryFolder folder_;
  S3Stub stub_;
  std::unique_ptr<MapStore> store_;
};

TEST_F(StoreAwayTest, MapsInMemoryServeAndTheRestIsUnavailableUntilItIsBack) {
  ASSERT_TRUE(Add("town", bytes_).ok());
  ASSERT_TRUE(Add("city", SmallMap("city")).ok());
  const absl::StatusOr<LoadedMap> used = store_->Acquire("town", 1);
  ASSERT_TRUE(used.ok()) << used.status();
  stub_.Stop();
  EXPECT_TRUE(store_->Acquire("town", 1).ok());
  const absl::Status refused = store_->Acquire("city", 1).status();
  EXPECT_TRUE(absl::IsUnavailable(refused)) << refused;
  EXPECT_THAT(MessageOf(refused), HasSubstr("try again"));
  EXPECT_TRUE(absl::IsUnavailable(Add("land", SmallMap("land"))));
  EXPECT_TRUE(absl::IsUnavailable(store_->Activate("city", 1).status()));
  Return();
  EXPECT_TRUE(store_->Acquire("city", 1).ok());
  EXPECT_TRUE(Add("land", SmallMap("land")).ok());
}

TEST_F(StoreAwayTest, AServerStartsWithoutTheCheckOfFiles) {
  ASSERT_TRUE(Add("town", bytes_).ok());
  EXPECT_EQ(store_->quarantined_count(), 0);
  stub_.Stop();
  Open();
  EXPECT_TRUE(store_->report().files_away);
  EXPECT_TRUE(store_->report().broken_files.empty());
  EXPECT_EQ(store_->quarantined_count(), std::nullopt);
  Return();
  EXPECT_TRUE(store_->Acquire("town", 1).ok());
  EXPECT_EQ(*store_->RemoveExpiredQuarantine({}), 0);
  EXPECT_EQ(store_->quarantined_count(), 0);
}

TEST_F(StoreAwayTest, WhatIsDeletedMeanwhileIsSetAsideLater) {
  ASSERT_TRUE(Add("town", bytes_).ok());
  stub_.Stop();
  EXPECT_TRUE(store_->DeleteVersion("town", 1).ok()) << "the catalogue knows of the file";
  Return();
  EXPECT_EQ(stub_.objects().size(), 1U);
  Open();
  EXPECT_EQ(store_->report().quarantined_file_count, 1);
}

TEST_F(StoreAwayTest, TheScrubTakesNoFileForDamaged) {
  ASSERT_TRUE(Add("town", bytes_).ok());
  stub_.Stop();
  const MapScrub scrub(store_->catalogue(), store_->files(), {.max_bytes_per_s = 1e9});
  std::this_thread::sleep_for(std::chrono::seconds(1));
  EXPECT_EQ(scrub.state().damaged_file_count, 0);
  EXPECT_EQ(scrub.state().pass_count, 0) << "it has read none";
}

TEST_F(StoreAwayTest, AnUploadThatTakesLongDelaysNoOtherChange) {
  ASSERT_TRUE(Add("town", bytes_).ok());
  stub_.FailNext({.kind = S3Fault::Kind::kNoAnswer}, 1, "PUT");
  std::thread upload([&] { Add("city", SmallMap("city")).IgnoreError(); });
  while (stub_.requests().back().substr(0, 3) != "PUT") {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(store_->Activate("town", 1).ok());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(300));
  upload.join();
}

}  // namespace
}  // namespace dcloc::server
