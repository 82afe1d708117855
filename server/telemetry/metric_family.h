#pragma once

#include <prometheus/metric_family.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace dcloc::server {

/// A gauge with one value.
prometheus::MetricFamily GaugeOf(const char* name, const char* help, double value);

/// A gauge with labels, of which `AddGauge` adds values.
prometheus::MetricFamily GaugeOf(const char* name, const char* help);
void AddGauge(prometheus::MetricFamily& family, std::vector<prometheus::ClientMetric::Label> labels,
              double value);

/// A counter with one value.
prometheus::MetricFamily CounterOf(const char* name, const char* help, double value);

/// A counter with a value for each of the label's values.
prometheus::MetricFamily CountersBy(
    const char* label, const char* name, const char* help,
    const std::vector<std::pair<const char*, std::int64_t>>& counts);

}  // namespace dcloc::server
