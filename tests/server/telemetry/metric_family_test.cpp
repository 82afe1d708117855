#include "server/telemetry/metric_family.h"

#include <gtest/gtest.h>

namespace dcloc::server {
namespace {

using prometheus::MetricType;

TEST(MetricFamilyTest, AGaugeHasAValueForEachSetOfLabels) {
  prometheus::MetricFamily family = GaugeOf("dcloc_maps", "Maps by tenant");
  EXPECT_TRUE(family.metric.empty());
  AddGauge(family, {{"tenant", "acme"}}, 2.0);
  AddGauge(family, {{"tenant", "umbrella"}}, 0.5);
  EXPECT_EQ(family.type, MetricType::Gauge);
  ASSERT_EQ(family.metric.size(), 2U);
  EXPECT_EQ(family.metric[0].label[0].value, "acme");
  EXPECT_EQ(family.metric[1].gauge.value, 0.5);
  EXPECT_EQ(GaugeOf("dcloc_maps", "Maps", 7.0).metric.at(0).gauge.value, 7.0);
}

TEST(MetricFamilyTest, ACounterIsOneEvenBeforeAnythingHappens) {
  const prometheus::MetricFamily family =
      CountersBy("outcome", "dcloc_scans_total", "Scans", {{"answered", 3}, {"rejected", 0}});
  EXPECT_EQ(family.type, MetricType::Counter);
  ASSERT_EQ(family.metric.size(), 2U);
  EXPECT_EQ(family.metric[0].label[0].name, "outcome");
  EXPECT_EQ(family.metric[0].counter.value, 3.0);
  EXPECT_EQ(family.metric[1].label[0].value, "rejected");
  EXPECT_EQ(family.metric[1].counter.value, 0.0);
  EXPECT_EQ(CounterOf("dcloc_calls_total", "Calls", 4.0).metric.at(0).counter.value, 4.0);
}

}  // namespace
}  // namespace dcloc::server
