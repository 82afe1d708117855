#include "server/telemetry/process_metrics.h"

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

namespace dcloc::server {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;

/// Within milliseconds of when the process was started.
const auto kStartTime = std::chrono::system_clock::now();

MetricFamily Single(const char* name, const char* help, MetricType type, double value) {
  ClientMetric metric;
  (type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  return {.name = name, .help = help, .type = type, .metric = {std::move(metric)}};
}

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

double ResidentMemory_bytes() {
  std::ifstream file("/proc/self/statm");
  double size_pages = 0.0;
  double resident_pages = 0.0;
  file >> size_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

}  // namespace

long OpenFileCount() {
  std::error_code error;
  long count = 0;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end;
       !error && entry != end; entry.increment(error)) {
    ++count;
  }
  return error ? -1 : count - 1;  // one of them is what was just read
}

long MaxFileCount() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  return static_cast<long>(limit.rlim_cur);
}

std::vector<MetricFamily> ProcessMetrics() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::vector<MetricFamily> families = {
      Single("process_cpu_seconds_total", "Processor time that the process took",
             MetricType::Counter, Seconds(usage.ru_utime) + Seconds(usage.ru_stime)),
      Single("process_resident_memory_bytes", "Memory that the process has", MetricType::Gauge,
             ResidentMemory_bytes()),
      Single("process_start_time_seconds", "When the process was started, Unix time",
             MetricType::Gauge,
             std::chrono::duration<double>(kStartTime.time_since_epoch()).count()),
      Single("process_max_fds", "File descriptors that may be open", MetricType::Gauge,
             static_cast<double>(MaxFileCount()))};
  if (const long count = OpenFileCount(); count >= 0) {
    families.push_back(Single("process_open_fds", "File descriptors that are open",
                              MetricType::Gauge, static_cast<double>(count)));
  }
  return families;
}

}  // namespace dcloc::server
