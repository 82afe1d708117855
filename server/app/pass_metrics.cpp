#include "server/app/pass_metrics.h"

#include "server/telemetry/metric_family.h"

namespace dcloc::server {

void AddPassMetrics(const PassCounts& counts, std::vector<prometheus::MetricFamily>& families) {
  families.push_back(CountersBy(
      "outcome", "dcloc_pass_scans_total",
      "Scans of sessions whose passes may be kept: taken, unworthy (not TRACKING, uncertain, or a "
      "source unsound), or dropped as the writer was behind",
      {{"taken", counts.taken_scans},
       {"unworthy", counts.unworthy_scans},
       {"dropped", counts.dropped_scans}}));
  families.push_back(CountersBy("outcome", "dcloc_passes_total",
                                "Passes: kept, too short, over a bound of storage, without consent "
                                "any more, or not stored",
                                {{"kept", counts.kept},
                                 {"too_short", counts.too_short},
                                 {"over_quota", counts.over_quota},
                                 {"withdrawn", counts.withdrawn},
                                 {"failed", counts.failed}}));
}

}  // namespace dcloc::server
