#include "client/evaluation/faults/protection_level.h"

#include <gtest/gtest.h>

#include <limits>

namespace dcloc::faults {
namespace {

using Cell = std::pair<int, int>;

TEST(StanfordHistogramTest, AnErrorAboveItsLevelIsCounted) {
  StanfordHistogram histogram;
  histogram.Add(0.5, 1.0);
  histogram.Add(1.0, 1.0);  // the level holds
  histogram.Add(1.5, 1.0);
  EXPECT_EQ(histogram.answers, 3U);
  EXPECT_EQ(histogram.exceeded, 1U);
}

TEST(StanfordHistogramTest, CellsAreTenthsOfADecade) {
  StanfordHistogram histogram;
  histogram.Add(0.1, 10.0);
  histogram.Add(0.0, std::numeric_limits<double>::infinity());
  EXPECT_EQ(histogram.counts, (std::map<Cell, std::size_t>{{{-10, 10}, 1}, {{-30, 30}, 1}}));
}

TEST(StanfordHistogramTest, PartsAddUpAndComeBackFromJson) {
  StanfordHistogram all;
  all.Add(0.1, 10.0);
  StanfordHistogram part;
  part.Add(0.1, 10.0);
  part.Add(5.0, 1.0);
  Merge(part, all);
  const StanfordHistogram back =
      StanfordFromJson(nlohmann::json::parse(StanfordToJson(all).dump()));
  EXPECT_EQ(back.counts.at({-10, 10}), 2U);
  EXPECT_EQ(back.counts, all.counts);
  EXPECT_EQ(back.answers, 3U);
  EXPECT_EQ(back.exceeded, 1U);
  EXPECT_THROW(StanfordFromJson(nlohmann::json::object()), nlohmann::json::exception);
}

}  // namespace
}  // namespace dcloc::faults
