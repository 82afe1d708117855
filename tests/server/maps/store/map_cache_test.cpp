#include "server/maps/store/map_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/base/files.h"
#include "server/maps/store/cache_folder.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"

namespace dcloc::server {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

Bytes Filled(char letter, std::size_t size = 1000) { return Bytes(size, std::byte(letter)); }

class MapCacheTest : public ::testing::Test {
 protected:
  std::unique_ptr<MapCache> Open(std::int64_t max_bytes = 3000) const {
    return *MapCache::Open(path_, max_bytes);
  }

  static void Write(MapCache& cache, const Bytes& bytes) { cache.Write(Sha256Of(bytes), bytes); }
  static bool Has(MapCache& cache, const Bytes& bytes) {
    const absl::StatusOr<Bytes> read = cache.Read(Sha256Of(bytes));
    EXPECT_TRUE(!read.ok() || *read == bytes);
    return read.ok();
  }
  fs::path PathOf(const Bytes& bytes) const { return CacheFolder::PathIn(path_, Sha256Of(bytes)); }

  /// As if it had last been used so long ago.
  void Age(const Bytes& bytes, std::chrono::hours age) const {
    fs::last_write_time(PathOf(bytes), fs::file_time_type::clock::now() - age);
  }

  std::int64_t UsedBytes() const {
    std::int64_t sum = 0;
    for (const auto& entry : fs::directory_iterator(path_)) {
      sum += static_cast<std::int64_t>(entry.file_size());
    }
    return sum;
  }

  const Bytes a_ = Filled('a'), b_ = Filled('b'), c_ = Filled('c'), d_ = Filled('d');
  TemporaryFolder folder_;
  const fs::path path_ = folder_.path() / "cache";
};

TEST_F(MapCacheTest, KeepsFilesOverRestartsForTheirOwnerAlone) {
  Write(*Open(), a_);
  const auto cache = Open();
  EXPECT_TRUE(Has(*cache, a_));
  EXPECT_FALSE(Has(*cache, b_));
  EXPECT_EQ(cache->counts().hits, 1);
  EXPECT_EQ(cache->counts().misses, 1);
  EXPECT_EQ(cache->counts().size_bytes, 1000);
  for (const auto& [path, mode] : {std::pair(path_, 0700), std::pair(PathOf(a_), 0600)}) {
    struct stat found {};
    ASSERT_EQ(stat(path.c_str(), &found), 0);
    EXPECT_EQ(found.st_mode & 0777U, static_cast<mode_t>(mode)) << path;
  }
}

TEST_F(MapCacheTest, TheLeastRecentlyUsedOnesGo) {
  const auto cache = Open();
  for (const Bytes& bytes : {a_, b_, c_}) Write(*cache, bytes);
  Age(a_, std::chrono::hours(3));
  Age(b_, std::chrono::hours(2));
  Age(c_, std::chrono::hours(1));
  EXPECT_TRUE(Has(*cache, a_)) << "it is now the one used last";
  Write(*cache, d_);
  EXPECT_FALSE(Has(*cache, b_));
  EXPECT_TRUE(Has(*cache, a_) && Has(*cache, c_) && Has(*cache, d_));
  EXPECT_EQ(cache->counts().evictions, 1);
  EXPECT_LE(UsedBytes(), 3000);
  EXPECT_EQ(MapCache::Open(path_, 1000).value()->counts().size_bytes, 1000) << "a smaller bound";
}

TEST_F(MapCacheTest, WhatSomeoneReadsStays) {
  const auto cache = Open();
  for (const Bytes& bytes : {a_, b_, c_}) Write(*cache, bytes);
  Age(a_, std::chrono::hours(3));
  Age(b_, std::chrono::hours(2));
  const FileDescriptor reader = *OpenToRead(PathOf(a_));
  MarkUsed(reader);
  Age(a_, std::chrono::hours(3));
  Write(*cache, d_);
  EXPECT_TRUE(fs::exists(PathOf(a_)));
  EXPECT_FALSE(fs::exists(PathOf(b_)));
  const FileDescriptor others[] = {*OpenToRead(PathOf(c_)), *OpenToRead(PathOf(d_))};
  for (const FileDescriptor& other : others) MarkUsed(other);
  Write(*cache, b_);
  EXPECT_FALSE(Has(*cache, b_)) << "no room without them";
  EXPECT_EQ(cache->counts().not_stored, 1);
}

TEST_F(MapCacheTest, AFileLargerThanTheBoundDropsNoOther) {
  const auto cache = Open();
  Write(*cache, a_);
  Write(*cache, Filled('x', 3001));
  EXPECT_TRUE(Has(*cache, a_));
  EXPECT_EQ(cache->counts().not_stored, 1);
}

TEST_F(MapCacheTest, ADamagedCopyIsNeverServed) {
  const auto cache = Open();
  Write(*cache, a_);
  fs::resize_file(PathOf(a_), 999);
  EXPECT_FALSE(Has(*cache, a_));
  EXPECT_FALSE(fs::exists(PathOf(a_)));
  Write(*cache, a_);
  folder_.Write("cache/" + PathOf(a_).filename().string(), b_);
  EXPECT_FALSE(Has(*cache, a_));
  EXPECT_EQ(cache->counts().damaged, 2);
  Write(*cache, a_);
  EXPECT_TRUE(Has(*cache, a_));
}

TEST_F(MapCacheTest, AFolderThatGoesComesBack) {
  const auto cache = Open();
  Write(*cache, a_);
  fs::remove_all(path_);
  EXPECT_FALSE(Has(*cache, a_));
  Write(*cache, b_);
  EXPECT_TRUE(Has(*cache, b_));
}

TEST_F(MapCacheTest, WhatAWriterThatWasKilledLeftIsRemoved) {
  Write(*Open(), a_);
  const pid_t writer = fork();
  if (writer == 0) {
    const auto part = CachePart::Begin(path_, "killed", 500);
    pause();
    _exit(part.ok() ? 0 : 1);
  }
  const fs::path left = path_ / "killed.part";
  while (!fs::exists(left) || fs::file_size(left) < 500) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const auto cache = Open();
  EXPECT_TRUE(fs::exists(left)) << "its writer lives";
  EXPECT_EQ(cache->counts().size_bytes, 1500) << "and has its room";
  kill(writer, SIGKILL);
  waitpid(writer, nullptr, 0);
  Write(*cache, b_);
  EXPECT_FALSE(fs::exists(left));
  EXPECT_TRUE(Has(*cache, a_) && Has(*cache, b_));
}

TEST_F(MapCacheTest, AFullDiskKeepsNothingAndLeavesNothing) {
  const auto cache = Open();
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{.rlim_cur = 100, .rlim_max = before.rlim_max};
  signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  Write(*cache, a_);
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(cache->counts().not_stored, 1);
  EXPECT_FALSE(Has(*cache, a_));
  EXPECT_EQ(UsedBytes(), 0);
  Write(*cache, a_);
  EXPECT_TRUE(Has(*cache, a_));
}

TEST_F(MapCacheTest, AFolderThatSomeoneKeepsLockedDelaysNobodyForLong) {
  const auto cache = Open();
  const CacheFolder lock = *CacheFolder::Lock(path_);
  const auto begin = std::chrono::steady_clock::now();
  Write(*cache, a_);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  EXPECT_EQ(cache->counts().not_stored, 1);
  EXPECT_TRUE(MapCache::Open(path_, 3000).ok());
}

TEST_F(MapCacheTest, AnotherUsersFolderIsRefused) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a folder away";
  fs::create_directories(path_);
  ASSERT_EQ(chown(path_.c_str(), 12345, 12345), 0);
  EXPECT_TRUE(absl::IsFailedPrecondition(MapCache::Open(path_, 3000).status()));
}

TEST_F(MapCacheTest, ProcessesThatShareAFolderKeepItsBoundAndServeWholeFiles) {
  constexpr int kProcesses = 3;
  std::vector<pid_t> pids;
  for (int process = 0; process < kProcesses; ++process) {
    pids.push_back(fork());
    if (pids.back() != 0) continue;
    const auto cache = Open();
    bool good = true;
    for (int i = 0; i < 100; ++i) {
      const Bytes bytes = Filled(static_cast<char>('a' + (i * (process + 1)) % 7), 900);
      const absl::StatusOr<Bytes> read = cache->Read(Sha256Of(bytes));
      good = good && (read.ok() ? *read == bytes : absl::IsNotFound(read.status()));
      if (!read.ok()) cache->Write(Sha256Of(bytes), bytes);
    }
    _exit(good && cache->counts().damaged == 0 ? 0 : 1);
  }
  for (const pid_t pid : pids) {
    int status = 0;
    waitpid(pid, &status, 0);
    EXPECT_EQ(status, 0);
  }
  EXPECT_LE(UsedBytes(), 3000);
  EXPECT_GT(UsedBytes(), 0);
}

}  // namespace
}  // namespace dcloc::server
