#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <future>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include "client/load/capacity_search.h"
#include "client/load/latency_histogram.h"
#include "client/load/load_options.h"
#include "client/load/load_report.h"
#include "client/load/recorder.h"
#include "client/load/scheduler.h"

namespace dcloc::load {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(LatencyHistogramTest, QuantilesAreRightToOnePerCent) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.QuantileMs(0.99), 0.0);
  for (int i = 1; i <= 1000; ++i) histogram.Add(std::chrono::microseconds(100 * i));
  for (const double p : {0.01, 0.5, 0.9, 0.99}) {
    EXPECT_GE(histogram.QuantileMs(p), 100.0 * p * (1.0 - 1e-9));
    EXPECT_LE(histogram.QuantileMs(p), 101.01 * p);
  }
  EXPECT_DOUBLE_EQ(histogram.QuantileMs(1.0), 100.0);
  EXPECT_NEAR(histogram.MeanMs(), 50.05, 1e-9);
}

TEST(LatencyHistogramTest, ExtremesAreCountedAndSumsAreMerged) {
  LatencyHistogram histogram;
  histogram.Add(0ns);
  histogram.Add(-5ns);
  LatencyHistogram other;
  other.Add(std::chrono::hours(10));
  histogram.Add(other);
  EXPECT_EQ(histogram.count(), 3);
  EXPECT_DOUBLE_EQ(histogram.max_ms(), 3.6e7);
  EXPECT_LE(histogram.QuantileMs(0.5), 0.001);
  histogram.Clear();
  EXPECT_EQ(histogram.count(), 0);
  EXPECT_EQ(histogram.max_ms(), 0.0);
}

TEST(SchedulerTest, TasksRunAtTheirTimeInTheirOrder) {
  std::mutex mutex;
  std::vector<int> order;
  std::promise<void> done;
  Scheduler scheduler;
  const auto begin = Scheduler::Clock::now();
  const auto note = [&](int number) {
    const std::lock_guard lock(mutex);
    order.push_back(number);
  };
  scheduler.At(begin + 60ms, [&] {
    note(3);
    done.set_value();
  });
  scheduler.At(begin + 30ms, [&] {
    note(1);
    scheduler.At(begin, [&] { note(2); });
  });
  scheduler.At(begin, [&] { note(0); });
  done.get_future().wait();
  EXPECT_GE(Scheduler::Clock::now() - begin, 60ms);
  EXPECT_THAT(order, ElementsAre(0, 1, 2, 3));
}

TEST(SchedulerTest, WhatHasNotBegunIsDropped) {
  bool ran = false;
  {
    Scheduler scheduler;
    scheduler.At(Scheduler::Clock::now() + std::chrono::hours(1), [&] { ran = true; });
  }
  EXPECT_FALSE(ran);
}

LoadResult ResultWith(int vehicle_count, double p99_ms) {
  LoadResult result{.vehicle_count = vehicle_count};
  result.record.totals.answered_count = 100;
  for (int i = 0; i < 100; ++i) {
    result.record.latency.Add(std::chrono::microseconds(std::llround(1000.0 * p99_ms)));
  }
  return result;
}

/// A server that holds the target up to `limit` vehicles.
Capacity CapacityOf(int limit, int first, int max) {
  return *SearchCapacity(first, max, 50.0, [&](int count) -> absl::StatusOr<LoadResult> {
    return ResultWith(count, count <= limit ? 10.0 : 100.0);
  });
}

TEST(CapacitySearchTest, FindsTheLimit) {
  for (const int limit : {1, 2, 7, 10, 11, 100, 137, 500}) {
    const Capacity capacity = CapacityOf(limit, 10, 2000);
    EXPECT_TRUE(capacity.is_limit) << limit;
    EXPECT_LE(capacity.vehicle_count, limit);
    EXPECT_GE(capacity.vehicle_count, limit - std::max(1, limit / 16)) << limit;
    EXPECT_LT(capacity.probes.size(), 16U) << limit;
  }
}

TEST(CapacitySearchTest, SaysWhenNothingOrEverythingHolds) {
  EXPECT_EQ(CapacityOf(0, 10, 100).vehicle_count, 0);
  const Capacity all = CapacityOf(1000, 10, 100);
  EXPECT_EQ(all.vehicle_count, 100);
  EXPECT_FALSE(all.is_limit);
  const auto failing = SearchCapacity(10, 100, 50.0, [](int) -> absl::StatusOr<LoadResult> {
    return absl::UnavailableError("gone");
  });
  EXPECT_EQ(failing.status().message(), "gone");
}

TEST(ShortfallsTest, NamesEachReason) {
  EXPECT_THAT(Shortfalls(ResultWith(1, 10.0), 50.0), ElementsAre());
  EXPECT_THAT(Shortfalls(ResultWith(1, 100.0), 0.0), ElementsAre()) << "no target";
  EXPECT_THAT(Shortfalls(ResultWith(1, 100.0), 50.0), ElementsAre(HasSubstr("p99 is 100")));
  EXPECT_THAT(Shortfalls(LoadResult{}, 50.0), ElementsAre(HasSubstr("no scan")));
  LoadResult result = ResultWith(1, 10.0);
  LoadTotals& totals = result.record.totals;
  totals.violations.Note("scan 2 was answered");
  totals.lost_count = 3;
  totals.skipped_count = 4;
  totals.dropped_count = 5;
  totals.refused.Note("no such radar");
  totals.broken.Note("too many pings");
  EXPECT_THAT(
      Shortfalls(result, 50.0),
      ElementsAre(HasSubstr("scan 2"), HasSubstr("3 scans were lost"), HasSubstr("4 scans"),
                  HasSubstr("5 scans"), HasSubstr("no such radar"), HasSubstr("too many pings")));
}

TEST(RecorderTest, CountsWhileItMeasures) {
  Recorder recorder;
  v1::LocalizeResponse answer;
  answer.mutable_result()->set_state(v1::LOCALIZATION_STATE_TRACKING);
  recorder.AddAnswer(answer, 5ms, true);
  recorder.AddSkipped();
  EXPECT_EQ(recorder.record().totals.answered_count, 0) << "not yet";
  recorder.Begin();
  recorder.AddAnswer(answer, 5ms, true);
  recorder.AddAnswer(answer, 900ms, /*counts_latency=*/false);
  recorder.AddError({.distance_m = 3.0, .misleading = true});
  v1::ScanRejected dropped;
  dropped.set_code(8);
  recorder.AddRejected(dropped);
  const LoadSecond second = recorder.EndSecond();
  EXPECT_EQ(second.answered_count, 1);
  EXPECT_NEAR(second.max_ms, 5.0, 0.1);
  recorder.End();
  recorder.AddAnswer(answer, 5ms, true);
  const LoadRecord record = recorder.record();
  EXPECT_EQ(record.totals.answered_count, 2);
  EXPECT_EQ(record.totals.tracking_count, 2);
  EXPECT_EQ(record.totals.misleading_count, 1);
  EXPECT_EQ(record.totals.dropped_count, 1);
  EXPECT_EQ(record.latency.count(), 1);
  EXPECT_EQ(record.seconds.size(), 1U);
}

TEST(LoadOptionsTest, BadOnesAreNamed) {
  const auto message_with = [](auto change) {
    LoadOptions options;
    change(options);
    const absl::Status status = Validate(options);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_TRUE(Validate(LoadOptions{}).ok());
  EXPECT_THAT(message_with([](LoadOptions& o) { o.vehicle_count = 0; }),
              HasSubstr("vehicle_count is 0"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.duration = 0ms; }), HasSubstr("duration is 0"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.warmup = -1ms; }), HasSubstr("warmup"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.ramp = -1ms; }), HasSubstr("ramp"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.drain = -1ms; }), HasSubstr("drain"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.arrival_jitter = -1us; }), HasSubstr("jitter"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.pace = 0.0; }), HasSubstr("pace is 0"));
  EXPECT_THAT(
      message_with([](LoadOptions& o) { o.pace = std::numeric_limits<double>::quiet_NaN(); }),
      HasSubstr("pace is nan"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.faults.disconnects_per_min = -1.0; }),
              HasSubstr("disconnects_per_min"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.faults.stalls_per_min = 1e9; }),
              HasSubstr("stalls_per_min"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.faults.stall_duration = 0ms; }),
              HasSubstr("stall_duration"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.faults.slow_reader_share = 2.0; }),
              HasSubstr("slow_reader_share"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.faults.slow_read_interval = 0ms; }),
              HasSubstr("slow_read_interval"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.faults.duplicate_share = -0.1; }),
              HasSubstr("duplicate_share"));
  EXPECT_THAT(message_with([](LoadOptions& o) { o.faults.reorder_share = 1.1; }),
              HasSubstr("reorder_share"));
}

TEST(LoadReportTest, TheLatencyPictureCanBeDrawn) {
  LoadResult result = ResultWith(10, 5.0);
  result.record.seconds = {{1.0, 10, 100, 1.0, 5.0, 6.0}, {2.0, 10, 100, 1.5, 5.0, 9.0}};
  const auto svg = RenderSvg(LatencyPicture(result));
  ASSERT_TRUE(svg.ok()) << svg.status();
  EXPECT_THAT(*svg, HasSubstr("10 vehicles"));
}

}  // namespace
}  // namespace dcloc::load
