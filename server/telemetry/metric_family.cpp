#include "server/telemetry/metric_family.h"

namespace dcloc::server {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;

MetricFamily GaugeOf(const char* name, const char* help) {
  return {.name = name, .help = help, .type = MetricType::Gauge, .metric = {}};
}

MetricFamily GaugeOf(const char* name, const char* help, double value) {
  MetricFamily family = GaugeOf(name, help);
  AddGauge(family, {}, value);
  return family;
}

void AddGauge(MetricFamily& family, std::vector<ClientMetric::Label> labels, double value) {
  ClientMetric metric;
  metric.label = std::move(labels);
  metric.gauge.value = value;
  family.metric.push_back(std::move(metric));
}

MetricFamily CounterOf(const char* name, const char* help, double value) {
  MetricFamily family{.name = name,
                      .help = help,
                      .type = MetricType::Counter,
                      .metric = std::vector<ClientMetric>(1)};
  family.metric[0].counter.value = value;
  return family;
}

MetricFamily CountersBy(const char* label, const char* name, const char* help,
                        const std::vector<std::pair<const char*, std::int64_t>>& counts) {
  MetricFamily family{.name = name, .help = help, .type = MetricType::Counter, .metric = {}};
  for (const auto& [value, count] : counts) {
    ClientMetric metric;
    metric.label = {{label, value}};
    metric.counter.value = static_cast<double>(count);
    family.metric.push_back(std::move(metric));
  }
  return family;
}

}  // namespace dcloc::server
