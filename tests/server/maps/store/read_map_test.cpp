#include "server/maps/store/read_map.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/test_maps.h"

namespace dcloc::server {
namespace {

class ReadMapTest : public ::testing::Test {
 protected:
  absl::StatusCode Read(const std::string& sha256) const {
    return ReadMap(path_, sha256).status().code();
  }

  const TemporaryFolder folder_;
  const std::vector<std::byte> bytes_ = SmallMap();
  const std::filesystem::path path_ = folder_.Write("map", bytes_);
};

TEST_F(ReadMapTest, GivesAMapOfTheRightHashOnly) {
  EXPECT_EQ((*ReadMap(path_, Sha256Of(bytes_)))->info().name, "spiral");
  EXPECT_EQ(Read(std::string(64, '0')), absl::StatusCode::kDataLoss);
}

TEST_F(ReadMapTest, TheRightHashOfNoMapIsDataLoss) {
  const std::vector<std::byte> text(100, std::byte{'x'});
  folder_.Write("map", text);
  EXPECT_EQ(Read(Sha256Of(text)), absl::StatusCode::kDataLoss);
}

TEST_F(ReadMapTest, WhatIsNoFileIsAnError) {
  std::filesystem::remove(path_);
  EXPECT_EQ(Read(Sha256Of(bytes_)), absl::StatusCode::kNotFound);
  ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
  EXPECT_EQ(Read(Sha256Of(bytes_)), absl::StatusCode::kDataLoss) << "it does not wait either";
}

TEST_F(ReadMapTest, AFileTooLargeForTheMemoryIsAnError) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer needs more address space than the test leaves";
#endif
  std::filesystem::resize_file(path_, std::uintmax_t{1} << 36);  // sparse
  const auto read_in_little_memory = [this] {
    const rlimit limit{.rlim_cur = rlim_t{1} << 33, .rlim_max = rlim_t{1} << 33};
    setrlimit(RLIMIT_AS, &limit);
    std::exit(static_cast<int>(Read(Sha256Of(bytes_))));
  };
  EXPECT_EXIT(read_in_little_memory(),
              ::testing::ExitedWithCode(static_cast<int>(absl::StatusCode::kResourceExhausted)),
              "");
}

TEST_F(ReadMapTest, ACheckReadsAllAndCanBeStopped) {
  std::size_t read_bytes = 0;
  const auto count = [&](std::size_t piece_bytes) {
    read_bytes += piece_bytes;
    return true;
  };
  EXPECT_TRUE(CheckMapFile(path_, Sha256Of(bytes_), count).ok());
  EXPECT_EQ(read_bytes, bytes_.size());
  EXPECT_TRUE(
      absl::IsCancelled(CheckMapFile(path_, Sha256Of(bytes_), [](std::size_t) { return false; })));
  EXPECT_TRUE(absl::IsDataLoss(CheckMapFile(path_, std::string(64, '0'), count)));
}

}  // namespace
}  // namespace dcloc::server
