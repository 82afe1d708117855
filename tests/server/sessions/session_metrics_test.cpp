#include "server/sessions/session_metrics.h"

#include <gtest/gtest.h>

namespace dcloc::server {
namespace {

constexpr std::chrono::microseconds kEncodingTime(5);

LocalizedScan TrackingScan() {
  LocalizedScan scan;
  scan.localization.state = LocalizationState::kTracking;
  return scan;
}

double CounterOf(const SessionMetrics& metrics, const std::string& family_name) {
  for (const prometheus::MetricFamily& family : metrics.registry()->Collect()) {
    if (family.name == family_name) return family.metric.front().counter.value;
  }
  return -1.0;
}

TEST(SessionMetricsTest, AnswersOfRadarsWithAWrongBetaAreCounted) {
  SessionMetrics metrics;
  LocalizedScan scan = TrackingScan();
  metrics.ObserveLocalized(scan, kEncodingTime);
  EXPECT_EQ(CounterOf(metrics, "dcloc_wrong_beta_answers_total"), 0.0);
  scan.localization.quality.beta.is_wrong = true;
  metrics.ObserveLocalized(scan, kEncodingTime);
  EXPECT_EQ(CounterOf(metrics, "dcloc_wrong_beta_answers_total"), 1.0);
}

TEST(SessionMetricsTest, OnlyMatchesAreJudgedAndEachOnce) {
  SessionMetrics metrics;
  LocalizedScan scan = TrackingScan();
  LocalizationQuality& quality = scan.localization.quality;
  scan.timings.registration = std::chrono::microseconds(200);
  metrics.ObserveLocalized(scan, kEncodingTime);
  quality.inlier_count = 40;
  quality.edge_distance = 2.5;
  quality.edge_valid = true;
  metrics.ObserveLocalized(scan, kEncodingTime);
  quality.edge_valid = false;
  metrics.ObserveLocalized(scan, kEncodingTime);
  scan.timings.registration = {};
  metrics.ObserveLocalized(scan, kEncodingTime);
  double distance_sum = 0.0;
  double edge_count = 0.0;
  for (const prometheus::MetricFamily& family : metrics.registry()->Collect()) {
    for (const prometheus::ClientMetric& metric : family.metric) {
      if (family.name == "dcloc_loop_edge_distance") distance_sum = metric.histogram.sample_sum;
      if (family.name == "dcloc_loop_edges_total") {
        EXPECT_EQ(metric.counter.value, 1.0) << metric.label.front().value;
        edge_count += metric.counter.value;
      }
    }
  }
  EXPECT_EQ(distance_sum, 5.0);
  EXPECT_EQ(edge_count, 2.0);
}

TEST(SessionMetricsTest, OnlyStagesThatRanAreTimed) {
  SessionMetrics metrics;
  LocalizedScan scan = TrackingScan();
  scan.timings.queue = std::chrono::microseconds(3);
  scan.timings.total = std::chrono::microseconds(20);
  metrics.ObserveLocalized(scan, kEncodingTime);
  for (const prometheus::MetricFamily& family : metrics.registry()->Collect()) {
    if (family.name == "dcloc_scan_seconds") {
      EXPECT_NEAR(family.metric.front().histogram.sample_sum, 25e-6, 1e-12);
    }
    if (family.name != "dcloc_scan_stage_seconds") continue;
    for (const prometheus::ClientMetric& metric : family.metric) {
      const std::string& stage = metric.label.front().value;
      const bool ran = stage == "queue" || stage == "encoding";
      EXPECT_EQ(metric.histogram.sample_count, ran ? 1U : 0U) << stage;
    }
  }
}

}  // namespace
}  // namespace dcloc::server
