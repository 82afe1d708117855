#pragma once

#include <prometheus/metric_family.h>

#include <vector>

#include "server/passes/pass_counts.h"

namespace dcloc::server {

/// Adds what became of passes and their scans.
void AddPassMetrics(const PassCounts& counts, std::vector<prometheus::MetricFamily>& families);

}  // namespace dcloc::server
