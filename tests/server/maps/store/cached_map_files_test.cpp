#include "server/maps/store/cached_map_files.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "server/maps/store/map_bucket.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/s3_stub.h"
#include "tests/server/fixtures/test_maps.h"

namespace dcloc::server {
namespace {

class CachedMapFilesTest : public ::testing::Test {
 protected:
  CachedMapFilesTest() { EXPECT_TRUE(files_.Keep(folder_.Write("upload", bytes_), sha256_).ok()); }

  int GetCount() const {
    int count = 0;
    for (const std::string& request : stub_.requests()) {
      count += absl::StartsWith(request, "GET /maps/site/maps/") ? 1 : 0;
    }
    return count;
  }

  const std::vector<std::byte> bytes_ = SmallMap();
  const std::string sha256_ = Sha256Of(bytes_);
  TemporaryFolder folder_;
  S3Stub stub_;
  const std::shared_ptr<MapCache> cache_ =
      *MapCache::Open(folder_.path() / "cache", std::int64_t{1} << 30);
  CachedMapFiles files_{std::make_unique<MapBucket>(*ObjectStore::Open(stub_.Options())), cache_};
};

TEST_F(CachedMapFilesTest, AFileIsFetchedOnceAndThenServedWithoutTheStorage) {
  ASSERT_TRUE(files_.Open(sha256_).ok());
  stub_.Stop();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(*files_.Read(sha256_), bytes_);
  EXPECT_EQ(cache_->counts().hits, 3);
  EXPECT_EQ(cache_->counts().misses, 1);
  EXPECT_TRUE(absl::IsUnavailable(files_.Read(std::string(64, 'a')).status()));
  EXPECT_TRUE(absl::IsUnavailable(files_.Check(sha256_, [](std::size_t) { return true; })))
      << "a check asks for the storage's bytes";
}

TEST_F(CachedMapFilesTest, ThoseWhoAskAtOnceShareOneLoad) {
  const int before = GetCount();
  std::vector<std::shared_ptr<const RadarMap>> maps(8);
  std::vector<std::thread> threads;
  stub_.FailNext({.kind = S3Fault::Kind::kReset}, 2, "GET");  // takes its time
  for (auto& map : maps) threads.emplace_back([&] { map = *files_.Open(sha256_); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& map : maps) EXPECT_EQ(map->info().size_bytes, bytes_.size());
  EXPECT_EQ(GetCount() - before, 3) << "two attempts that broke off, and a good one";
}

TEST_F(CachedMapFilesTest, WithoutRoomItServesAllTheSame) {
  const auto none = std::shared_ptr<MapCache>(*MapCache::Open(folder_.path() / "none", 1));
  CachedMapFiles files(std::make_unique<MapBucket>(*ObjectStore::Open(stub_.Options())), none);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(*files.Read(sha256_), bytes_);
  EXPECT_EQ(none->counts().not_stored, 2);
  EXPECT_EQ(none->counts().size_bytes, 0);
}

TEST_F(CachedMapFilesTest, WhatIsRemovedOrSetAsideLeavesTheCacheToo) {
  ASSERT_TRUE(files_.Open(sha256_).ok());
  ASSERT_TRUE(files_.Quarantine(sha256_).ok());
  EXPECT_TRUE(absl::IsNotFound(files_.Open(sha256_).status()));
  ASSERT_TRUE(files_.Keep(folder_.Write("upload", bytes_), sha256_).ok());
  ASSERT_TRUE(files_.Open(sha256_).ok());
  ASSERT_TRUE(files_.Remove(sha256_).ok());
  EXPECT_TRUE(absl::IsNotFound(files_.Open(sha256_).status()));
}

}  // namespace
}  // namespace dcloc::server
