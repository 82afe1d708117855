#include "server/maps/store/tenant_quota.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/maps/store/map_store_fixture.h"

namespace dcloc::server {
namespace {

class TenantQuotaTest : public StoreFixture {
 protected:
  static StorageClaim Claim(char digit, std::int64_t size_bytes, const std::string& tenant = "") {
    return {.tenant = tenant,
            .prefix = tenant.empty() ? "" : tenant + "/",
            .sha256 = std::string(64, digit),
            .size_bytes = size_bytes};
  }
};

TEST_F(TenantQuotaTest, OfManyUploadsAtOnceOnlyThoseThatFitBegin) {
  constexpr int kUploads = 12;
  std::atomic<int> begun = 0;
  std::mutex mutex;
  std::vector<Hold> holds;
  std::vector<std::jthread> threads;
  threads.reserve(kUploads);
  for (int i = 0; i < kUploads; ++i) {
    threads.emplace_back([&, i] {
      absl::StatusOr<Hold> hold =
          store_->quota().Reserve(Claim(static_cast<char>('a' + i), 300), 1000);
      if (!hold.ok()) return;
      ++begun;
      const std::lock_guard lock(mutex);
      holds.push_back(*std::move(hold));
    });
  }
  threads.clear();
  EXPECT_EQ(begun, 3);
}

TEST_F(TenantQuotaTest, EachTenantHasItsOwn) {
  const absl::StatusOr<Hold> first = store_->quota().Reserve(Claim('a', 900), 1000);
  EXPECT_TRUE(first.ok());
  EXPECT_TRUE(store_->quota().Reserve(Claim('b', 900, "acme"), 1000).ok());
  EXPECT_FALSE(store_->quota().Reserve(Claim('b', 900), 1000).ok());
  EXPECT_TRUE(store_->quota().Reserve(Claim('b', 900), 0).ok()) << "no limit";
}

TEST_F(TenantQuotaTest, AHoldMayOutliveTheStore) {
  absl::StatusOr<Hold> hold = store_->quota().Reserve(Claim('a', 900), 1000);
  Close();
  EXPECT_TRUE(hold.ok());
}

}  // namespace
}  // namespace dcloc::server
