#include "server/maps/store/warm_maps.h"

#include <gtest/gtest.h>

#include <memory>

namespace dcloc::server {
namespace {

TEST(WarmMapsTest, KeepsThoseUsedLastWithinItsRoom) {
  WarmMaps warm(100);
  const auto map = std::make_shared<int>();
  warm.Keep({"a", 1}, map, 40);
  warm.Keep({"b", 1}, map, 40);
  warm.Keep({"a", 1}, map, 40);  // used again
  EXPECT_EQ(warm.size_bytes(), 80);
  warm.Keep({"c", 1}, map, 40);
  EXPECT_TRUE(warm.Has({"a", 1}));
  EXPECT_FALSE(warm.Has({"b", 1})) << "longest unused";
  EXPECT_TRUE(warm.Has({"c", 1}));
  EXPECT_EQ(warm.size_bytes(), 80);
  warm.Keep({"huge", 1}, map, 101);
  EXPECT_FALSE(warm.Has({"huge", 1}));
  EXPECT_EQ(warm.size_bytes(), 80) << "and costs no other its place";
  EXPECT_EQ(map.use_count(), 3);
}

TEST(WarmMapsTest, KeepsOnlyTheVersionsThatAreNamed) {
  WarmMaps warm(100);
  const auto map = std::make_shared<int>();
  for (const std::int64_t version : {1, 2, 3}) warm.Keep({"a", version}, map, 10);
  warm.Keep({"b", 1}, map, 10);
  warm.KeepOnly("a", 3, 1);
  EXPECT_TRUE(warm.Has({"a", 1}));
  EXPECT_FALSE(warm.Has({"a", 2}));
  EXPECT_TRUE(warm.Has({"a", 3}));
  EXPECT_TRUE(warm.Has({"b", 1})) << "another map";
}

}  // namespace
}  // namespace dcloc::server
