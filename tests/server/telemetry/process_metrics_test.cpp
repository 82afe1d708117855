#include "server/telemetry/process_metrics.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <string>

#include "server/base/files.h"

namespace dcloc::server {
namespace {

double ValueOf(const std::string& name) {
  for (const prometheus::MetricFamily& family : ProcessMetrics()) {
    if (family.name != name) continue;
    const prometheus::ClientMetric& metric = family.metric.at(0);
    return family.type == prometheus::MetricType::Counter ? metric.counter.value
                                                          : metric.gauge.value;
  }
  ADD_FAILURE() << "no metric " << name;
  return -1.0;
}

TEST(ProcessMetricsTest, DescriptorsAreCountedAsTheyOpen) {
  const long before = OpenFileCount();
  ASSERT_GT(before, 0);
  const FileDescriptor null(open("/dev/null", O_RDONLY));
  EXPECT_EQ(OpenFileCount(), before + 1);
  EXPECT_EQ(ValueOf("process_open_fds"), static_cast<double>(before + 1));
  EXPECT_GE(MaxFileCount(), OpenFileCount());
}

TEST(ProcessMetricsTest, TimesAndMemoryAreInTheirUnits) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const double now_s = std::chrono::duration<double>(now).count();
  EXPECT_LE(ValueOf("process_start_time_seconds"), now_s);
  EXPECT_GT(ValueOf("process_start_time_seconds"), now_s - 3600.0);
  EXPECT_GT(ValueOf("process_resident_memory_bytes"), 1e6);  // more than a page count
  const double before_s = ValueOf("process_cpu_seconds_total");
  rusage usage{};
  const auto used_s = [&usage] {
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  };
  EXPECT_LE(before_s, used_s());
  EXPECT_NEAR(before_s, used_s(), 1.0);
}

}  // namespace
}  // namespace dcloc::server
