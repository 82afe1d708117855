#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/core/localizer/adversary.h"
#include "tests/core/localizer/on_a_road.h"

namespace dcloc {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(NDEBUG)
constexpr bool kIsAsServed = false;  // time and memory are the sanitizer's or the debugger's
#else
constexpr bool kIsAsServed = true;
#endif
constexpr double kGoal_ms = 50.0;
// A machine that does other things as well takes several times as long, also of its processor.
constexpr double kMaxScan_ms = 250.0;
constexpr double kMaxGrowth_mib = 32.0;
constexpr int kSessionScans = 2000;
constexpr int kLongSessionScans = 20'000;

/// Of this thread, so that what else the machine does counts for nothing.
double ProcessorTime_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

double Resident_mib() {
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  double resident_pages = 0.0;
  file >> pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

int ScanCount() {
  const char* count = std::getenv("DCLOC_PROPERTY_SCANS");
  return count == nullptr ? 6000 : std::stoi(count);
}

class LocalizerPropertyTest : public OnARoad {
 protected:
  static Localizer MakeOne(unsigned seed) {
    Rig rig = FrontRadar();
    rig.radars.push_back(rig.radars[0]);
    rig.radars[1].id = "second";
    std::optional<InitialPose> prior;
    if (seed % 3 != 0) prior = PriorAt(Start(), seed % 3 == 1 ? 0.3 : 30.0, 0.05);
    return MakeLocalizer(map_, rig, prior);
  }

  void TakeFix(Localizer& localizer, const PositionFix& fix) {
    const auto use = localizer.TakeFix(fix);
    ASSERT_TRUE(use.ok() || absl::IsInvalidArgument(use.status())) << use.status();
    ++fix_count_;
  }

  void Localize(Localizer& localizer, const Scan& scan) {
    const double begin_ms = ProcessorTime_ms();
    const auto answer = localizer.Localize(scan);
    const double took_ms = ProcessorTime_ms() - begin_ms;
    if (took_ms > slowest_ms_) slowest_index_ = scan_count_;
    if (took_ms > kGoal_ms) ++slow_count_;
    slowest_ms_ = std::max(slowest_ms_, took_ms);
    ++scan_count_;
    if (!answer.ok()) {
      ASSERT_EQ(answer.status().code(), absl::StatusCode::kInvalidArgument);
      return;
    }
    ++answered_count_;
    ASSERT_TRUE(answer->T_map_vehicle.translation_m.allFinite());
    ASSERT_NEAR(answer->T_map_vehicle.rotation.norm(), 1.0, 1e-6);
    ASSERT_TRUE(answer->covariance.allFinite());
    ASSERT_GE(answer->covariance.diagonal().minCoeff(), 0.0);
  }

  int scan_count_ = 0;
  int answered_count_ = 0;
  int fix_count_ = 0;
  int slow_count_ = 0;
  int slowest_index_ = 0;
  double slowest_ms_ = 0.0;
};

// DCLOC_PROPERTY_SCANS says how many.
TEST_F(LocalizerPropertyTest, WhateverIsSentAnAnswerIsFiniteSoonAndOfBoundedMemory) {
  double first_mib = 0.0;
  for (unsigned seed = 0; scan_count_ < ScanCount(); ++seed) {
    SCOPED_TRACE(seed);
    Adversary adversary(drive_, seed);
    Localizer localizer = MakeOne(seed);
    const int session_scans = seed % 10 == 9 ? kLongSessionScans : kSessionScans;
    for (int i = 0; i < session_scans && scan_count_ < ScanCount(); ++i) {
      SCOPED_TRACE(i);
      ASSERT_NO_FATAL_FAILURE(Localize(localizer, adversary.NextScan()));
      if (!adversary.Once(5)) continue;
      ASSERT_NO_FATAL_FAILURE(TakeFix(localizer, adversary.NextFix()));
    }
    if (seed == 0) first_mib = Resident_mib();
  }
  const double growth_mib = Resident_mib() - first_mib;
  EXPECT_GT(answered_count_, scan_count_ / 2);
  if (kIsAsServed) {
    EXPECT_LT(slowest_ms_, kMaxScan_ms);
    EXPECT_LT(growth_mib, kMaxGrowth_mib);
  }
  std::printf(
      "%d scans, %d answered, %d fixes; scan %d took longest, %.1f ms of a processor, %d took "
      "above "
      "%.0f ms; %.1f MiB more than after the first session\n",
      scan_count_, answered_count_, fix_count_, slowest_index_, slowest_ms_, slow_count_, kGoal_ms,
      growth_mib);
}

}  // namespace
}  // namespace dcloc
