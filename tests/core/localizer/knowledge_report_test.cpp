#include "core/localizer/knowledge_report.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

constexpr Stamp kBegin{std::chrono::seconds(1'700'000'000)};

RigKnowledge Scale(double value, double sigma) {
  RigKnowledge known;
  known.wheel_scale = {value, sigma * sigma};
  return known;
}

TEST(KnowledgeReportTest, IsLookedAtOnceAnInterval) {
  KnowledgeReport report({.interval = std::chrono::seconds(5)});
  EXPECT_FALSE(report.IsDue(kBegin)) << "nothing can have been learned yet";
  EXPECT_FALSE(report.IsDue(kBegin + std::chrono::milliseconds(4999)));
  EXPECT_TRUE(report.IsDue(kBegin + std::chrono::seconds(5)));
  EXPECT_FALSE(report.IsDue(kBegin + std::chrono::seconds(6)));
  EXPECT_TRUE(report.IsDue(kBegin + std::chrono::seconds(10)));
}

TEST(KnowledgeReportTest, ReportsWhatHasChangedAndNothingElse) {
  KnowledgeReport report({});
  EXPECT_FALSE(report.OnKnown({}).has_value());
  const auto first = report.OnKnown(Scale(1.02, 0.01));
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->wheel_scale->value, 1.02);
  EXPECT_FALSE(report.OnKnown(Scale(1.021, 0.01)).has_value());
  EXPECT_TRUE(report.OnKnown(Scale(1.05, 0.01)).has_value());
  EXPECT_TRUE(report.OnKnown(Scale(1.05, 0.004)).has_value()) << "it is known twice as well";
}

TEST(KnowledgeReportTest, ChangesAddUpSinceTheyWereReported) {
  KnowledgeReport report({});
  ASSERT_TRUE(report.OnKnown(Scale(1.0, 0.01)).has_value());
  EXPECT_FALSE(report.OnKnown(Scale(1.008, 0.01)).has_value());
  EXPECT_TRUE(report.OnKnown(Scale(1.016, 0.01)).has_value());
}

}  // namespace
}  // namespace dcloc
