#include "client/datasets/check/mapping_correction.h"

#include <gtest/gtest.h>

#include <vector>

namespace dcloc {
namespace {

RadarMapping Corrected(RangeRateMeaning meaning, RadarMapping radar = {.id = "front"}) {
  const std::vector<RangeRateCheck> checks = {{.radar_id = "other"},
                                              {.radar_id = "front", .meaning = meaning}};
  return CorrectedMapping({.radars = {std::move(radar)}}, checks).radars[0];
}

TEST(MappingCorrectionTest, WhatTheDataShowIsBesideWhatTheMappingSays) {
  using enum RangeRateMeaning;
  EXPECT_TRUE(Corrected(kTowards).range_rate_is_towards);
  EXPECT_FALSE(Corrected(kTowards).azimuth_is_clockwise);
  const RadarMapping turned = {.id = "front", .range_rate_is_towards = true};
  EXPECT_FALSE(Corrected(kTowards, turned).range_rate_is_towards);
  EXPECT_TRUE(Corrected(kAwayMirrored, turned).azimuth_is_clockwise);
  EXPECT_TRUE(Corrected(kAwayMirrored, turned).range_rate_is_towards);
  EXPECT_TRUE(Corrected(kTowardsMirrored).azimuth_is_clockwise);
  EXPECT_TRUE(Corrected(kCompensated).range_rate_is_compensated);
}

TEST(MappingCorrectionTest, WhatNoSignMendsStays) {
  using enum RangeRateMeaning;
  for (const RangeRateMeaning meaning : {kUnknown, kAway, kOfAnotherMount, kNothingFits}) {
    const RadarMapping radar = Corrected(meaning);
    EXPECT_FALSE(radar.range_rate_is_towards || radar.azimuth_is_clockwise ||
                 radar.range_rate_is_compensated);
  }
}

}  // namespace
}  // namespace dcloc
