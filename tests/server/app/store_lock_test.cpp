#include "server/app/store_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class StoreLockTest : public ::testing::Test {
 protected:
  std::string Notice() const {
    std::ifstream file(path_);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "lock";
};

TEST_F(StoreLockTest, OneProcessOfAHostHasIt) {
  {
    const auto lock = StoreLock::Take(path_, "here");
    ASSERT_TRUE(lock.ok()) << lock.status();
    EXPECT_THAT(Notice(), StartsWith("here:"));
    EXPECT_EQ(StoreLock::Take(path_, "here").status().code(),
              absl::StatusCode::kFailedPrecondition);
  }
  EXPECT_EQ(Notice(), "");
  EXPECT_TRUE(StoreLock::Take(path_, "here").ok());
}

TEST_F(StoreLockTest, AnotherHostsIsNoticedWithoutItsLock) {
  // Another path to the same file stands for a file system that keeps locks to a host: a copy of
  // the notice, with the time of its changes, comes to where this one looks.
  const std::filesystem::path there = folder_.path() / "there";
  const auto other = StoreLock::Take(there, "there");
  ASSERT_TRUE(other.ok()) << other.status();
  std::ofstream(path_) << "there:1";
  const Ticker carrier(StoreLock::kBeat / 2, [&] {
    std::filesystem::last_write_time(path_, std::filesystem::last_write_time(there));
  });
  const auto begin = std::chrono::steady_clock::now();
  const absl::Status status = StoreLock::Take(path_, "here").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(status), HasSubstr("there:1"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, StoreLock::kPatience);
}

TEST_F(StoreLockTest, OneThatStandsStillIsTakenOver) {
  std::ofstream(path_) << "there:1";
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(StoreLock::Take(path_, "here").ok());
  EXPECT_GE(std::chrono::steady_clock::now() - begin, StoreLock::kPatience);
}

TEST_F(StoreLockTest, AfterACrashOnTheSameHostNobodyWaits) {
  std::ofstream(path_) << "here:1";
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(StoreLock::Take(path_, "here").ok());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, StoreLock::kPatience);
}

}  // namespace
}  // namespace dcloc::server
