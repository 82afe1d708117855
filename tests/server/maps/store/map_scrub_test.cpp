#include "server/maps/store/map_scrub.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "tests/server/maps/store/map_store_fixture.h"

namespace dcloc::server {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

class MapScrubTest : public StoreFixture {
 protected:
  MapScrubTest() { Put(bytes_); }

  /// Whether it finds so many files damaged within some seconds.
  static bool Finds(const MapScrub& scrub, int count) {
    const auto end = Clock::now() + std::chrono::seconds(10);
    while (Clock::now() < end) {
      const ScrubState state = scrub.state();
      if (state.pass_count > 0 && state.damaged_file_count == count) return true;
      std::this_thread::sleep_for(milliseconds(5));
    }
    return false;
  }

  void Damage() const {
    std::fstream(FileOf(bytes_), std::ios::in | std::ios::out | std::ios::binary).put('?');
  }

  static constexpr MapScrubOptions kFast{.max_bytes_per_s = 1e9, .pass_interval = milliseconds(10)};
  const std::vector<std::byte> bytes_ = SmallMap("long", 700);
};

TEST_F(MapScrubTest, FindsDamageAndThatItWasMended) {
  const MapScrub scrub(store_->catalogue(), store_->files(), kFast);
  EXPECT_TRUE(Finds(scrub, 0));
  Damage();
  EXPECT_TRUE(Finds(scrub, 1));
  Put(bytes_);
  EXPECT_TRUE(Finds(scrub, 0));
  EXPECT_GE(scrub.state().checked_bytes, static_cast<std::int64_t>(bytes_.size()));
}

TEST_F(MapScrubTest, FindsAMissingFileUntilItsVersionIsDeleted) {
  const MapScrub scrub(store_->catalogue(), store_->files(), kFast);
  std::filesystem::remove(FileOf(bytes_));
  EXPECT_TRUE(Finds(scrub, 1));
  ASSERT_TRUE(store_->DeleteMap("town").ok());
  EXPECT_TRUE(Finds(scrub, 0));
}

TEST_F(MapScrubTest, KeepsToItsRateAndEndsAtOnce) {
  const auto begin = Clock::now();
  {
    const MapScrub scrub(store_->catalogue(), store_->files(), {.max_bytes_per_s = 1e6});
    std::this_thread::sleep_for(milliseconds(400));
    EXPECT_LE(scrub.state().checked_bytes, 1'000'000);
  }
  EXPECT_LT(Clock::now() - begin, milliseconds(1500));
}

TEST_F(MapScrubTest, AtNoRateNothingIsRead) {
  const MapScrub scrub(store_->catalogue(), store_->files(), {.max_bytes_per_s = 0.0});
  std::this_thread::sleep_for(milliseconds(50));
  EXPECT_EQ(scrub.state().pass_count, 0);
}

}  // namespace
}  // namespace dcloc::server
