#include "server/base/memory_reserve.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

namespace dcloc::server {
namespace {

constexpr std::size_t kReserve_bytes = std::size_t{8} << 20;

/// Lets the process have `spare_bytes` of address space more than it has now, as long as it lives.
class AddressLimit {
 public:
  explicit AddressLimit(std::size_t spare_bytes) {
    getrlimit(RLIMIT_AS, &before_);
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const std::size_t page_bytes = sysconf(_SC_PAGESIZE);
    const rlimit limit{.rlim_cur = pages * page_bytes + spare_bytes, .rlim_max = before_.rlim_max};
    setrlimit(RLIMIT_AS, &limit);
  }
  AddressLimit(const AddressLimit&) = delete;
  AddressLimit& operator=(const AddressLimit&) = delete;
  ~AddressLimit() { setrlimit(RLIMIT_AS, &before_); }

 private:
  rlimit before_{};
};

bool CanMap(std::size_t size_bytes) {
  void* const pages =
      mmap(nullptr, size_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages == MAP_FAILED) return false;
  munmap(pages, size_bytes);
  return true;
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SKIP_UNDER_SANITIZERS GTEST_SKIP() << "a sanitizer needs address space of its own"
#else
#define SKIP_UNDER_SANITIZERS static_cast<void>(0)
#endif

TEST(MemoryReserveTest, NothingIsShortWhereNothingIsKept) {
  MemoryReserve reserve;
  EXPECT_FALSE(reserve.IsGiven());
  reserve.Give();
  EXPECT_FALSE(reserve.IsGiven());
  EXPECT_TRUE(reserve.Tend());
}

TEST(MemoryReserveTest, WhatIsGivenIsThereForOthers) {
  SKIP_UNDER_SANITIZERS;
  MemoryReserve reserve;
  ASSERT_TRUE(reserve.Keep(kReserve_bytes));
  const AddressLimit limit(kReserve_bytes / 8);
  ASSERT_FALSE(CanMap(kReserve_bytes / 2));
  reserve.Give();
  EXPECT_TRUE(reserve.IsGiven());
  EXPECT_TRUE(CanMap(kReserve_bytes / 2));
}

TEST(MemoryReserveTest, ItIsTakenBackWhenMoreIsThereThanItNeeds) {
  SKIP_UNDER_SANITIZERS;
  MemoryReserve reserve;
  ASSERT_TRUE(reserve.Keep(kReserve_bytes));
  reserve.Give();
  {
    const AddressLimit limit(kReserve_bytes);
    EXPECT_FALSE(reserve.Tend()) << "nothing would be left";
    EXPECT_TRUE(reserve.IsGiven());
  }
  const AddressLimit limit(kReserve_bytes / 2 * 3);
  EXPECT_TRUE(reserve.Tend());
  EXPECT_FALSE(reserve.IsGiven());
}

TEST(MemoryReserveTest, ItIsGivenBeforeTheLastIsTaken) {
  SKIP_UNDER_SANITIZERS;
  MemoryReserve reserve;
  ASSERT_TRUE(reserve.Keep(kReserve_bytes));
  {
    const AddressLimit limit(kReserve_bytes / 8);
    EXPECT_TRUE(reserve.Tend()) << "something is left";
  }
  const AddressLimit limit(kReserve_bytes / 32);
  EXPECT_FALSE(reserve.Tend());
  EXPECT_TRUE(CanMap(kReserve_bytes / 2));
}

TEST(MemoryReserveTest, NothingIsKeptWhereThereIsNoRoomForIt) {
  SKIP_UNDER_SANITIZERS;
  MemoryReserve reserve;
  const AddressLimit limit(kReserve_bytes / 2);
  EXPECT_FALSE(reserve.Keep(kReserve_bytes));
  EXPECT_FALSE(reserve.IsGiven()) << "calls are taken";
  EXPECT_TRUE(reserve.Tend());
}

}  // namespace
}  // namespace dcloc::server
