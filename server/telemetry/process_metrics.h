#pragma once

#include <prometheus/metric_family.h>

#include <vector>

namespace dcloc::server {

/// What Prometheus' own clients say of every process: processor time, memory, file descriptors and
/// when it was started. What the system does not tell is left out.
std::vector<prometheus::MetricFamily> ProcessMetrics();

/// File descriptors that are open; -1 where the system does not say.
long OpenFileCount();

/// The most file descriptors that may be open.
long MaxFileCount();

}  // namespace dcloc::server
