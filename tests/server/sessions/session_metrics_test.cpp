#include "server/sessions/session_metrics.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

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

double CounterOf(const SessionMetrics& metrics, const std::string& family_name,
                 const std::vector<std::string>& labels) {
  for (const prometheus::MetricFamily& family : metrics.registry()->Collect()) {
    if (family.name != family_name) continue;
    for (const prometheus::ClientMetric& metric : family.metric) {
      std::vector<std::string> values;
      for (const auto& label : metric.label) values.push_back(label.value);
      if (values == labels) return metric.counter.value;
    }
  }
  return -1.0;
}

TEST(SessionMetricsTest, SourcesSetAsideAreCountedByKindAndReason) {
  SessionMetrics metrics;
  const auto count = [&](const std::string& reason) {
    return CounterOf(metrics, "dcloc_sources_set_aside_total", {reason, "radar"});
  };
  EXPECT_EQ(count("mount"), 0.0) << "there from the start";
  HealthChanges changes{.set_aside = {false, false, true}, .new_reset_count = 2};
  changes.sources = {{.health = {.is_used = false, .fault = SourceFault::kMount}},
                     {.health = {.is_used = true, .fault = SourceFault::kNone}}};
  metrics.ObserveHealth(changes);
  metrics.ObserveHealth({.set_aside = {false, false, true}});
  EXPECT_EQ(count("mount"), 1.0);
  EXPECT_EQ(count("none"), 0.0) << "it was taken back";
  const char kAnswers[] = "dcloc_answers_with_source_set_aside_total";
  EXPECT_EQ(CounterOf(metrics, kAnswers, {"radar"}), 2.0);
  EXPECT_EQ(CounterOf(metrics, kAnswers, {"wheel_speed"}), 0.0);
  EXPECT_EQ(CounterOf(metrics, "dcloc_pose_resets_total"), 2.0);
}

TEST(SessionMetricsTest, FixesAreCountedByWhatBecameOfThem) {
  SessionMetrics metrics;
  metrics.ObserveFix(FixUse::kConsistentNotFused);
  metrics.ObserveFix(FixUse::kOutOfTime);
  metrics.ObserveFix(absl::InvalidArgumentError("no"));
  metrics.ObserveFix(absl::FailedPreconditionError("no anchor"));
  metrics.ObserveFix(absl::ResourceExhaustedError("too many"));
  const auto count = [&](const std::string& use) {
    return CounterOf(metrics, "dcloc_position_fixes_total", {use});
  };
  EXPECT_EQ(count("fused"), 0.0);
  EXPECT_EQ(count("agrees"), 1.0);
  EXPECT_EQ(count("out_of_time"), 1.0);
  EXPECT_EQ(count("invalid"), 2.0);
  EXPECT_EQ(count("over_limit"), 1.0);
}

TEST(SessionMetricsTest, AnswersWithoutAProtectionLevelAreNotInItsHistogram) {
  SessionMetrics metrics;
  LocalizedScan scan = TrackingScan();
  metrics.ObserveLocalized(scan, kEncodingTime);
  scan.localization.protection_level_m = 0.4;
  metrics.ObserveLocalized(scan, kEncodingTime);
  for (const prometheus::MetricFamily& family : metrics.registry()->Collect()) {
    if (family.name != "dcloc_protection_level_meters") continue;
    EXPECT_EQ(family.metric.front().histogram.sample_count, 1U);
    EXPECT_EQ(family.metric.front().histogram.sample_sum, 0.4);
  }
}

TEST(SessionMetricsTest, OnlyMatchesAreJudgedAndEachOnce) {
  SessionMetrics metrics;
  LocalizedScan scan = TrackingScan();
  LocalizationQuality& quality = scan.localization.quality;
  scan.timings.registration = std::chrono::microseconds(200);
  metrics.ObserveLocalized(scan, kEncodingTime);
  quality.inlier_count = 40;
  quality.normalized_innovation_squared = 2.5;
  quality.is_accepted = true;
  metrics.ObserveLocalized(scan, kEncodingTime);
  quality.is_accepted = false;
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
