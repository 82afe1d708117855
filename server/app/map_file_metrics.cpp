#include "server/app/map_file_metrics.h"

#include "server/telemetry/metric_family.h"

namespace dcloc::server {
namespace {

void AddObjects(const ObjectStore& objects, std::vector<prometheus::MetricFamily>& families) {
  const ObjectCounts& counts = objects.counts();
  families.push_back(GaugeOf("dcloc_object_store_away",
                             "1 when the store of map files did not answer last time",
                             objects.away() ? 1.0 : 0.0));
  families.push_back(CountersBy(
      "outcome", "dcloc_object_store_requests_total",
      "Requests to the store of map files: answered, or failed after all "
      "attempts; a repeated one is an attempt beyond a request's first",
      {{"answered", counts.answered}, {"failed", counts.failed}, {"repeated", counts.repeated}}));
  families.push_back(CountersBy("direction", "dcloc_object_store_bytes_total",
                                "Bytes that went from and to the store of map files",
                                {{"read", counts.read_bytes}, {"written", counts.written_bytes}}));
}

void AddCache(const MapCache& cache, std::vector<prometheus::MetricFamily>& families) {
  const MapCacheCounts& counts = cache.counts();
  families.push_back(CountersBy("outcome", "dcloc_map_cache_reads_total",
                                "Map files that were looked for in this host's cache",
                                {{"hit", counts.hits}, {"miss", counts.misses}}));
  families.push_back(CounterOf("dcloc_map_cache_evictions_total",
                               "Map files that left the cache for others",
                               static_cast<double>(counts.evictions)));
  families.push_back(CountersBy("reason", "dcloc_map_cache_failures_total",
                                "Map files that were damaged in the cache and removed, or that it "
                                "had no room for or could not write",
                                {{"damaged", counts.damaged}, {"not_stored", counts.not_stored}}));
  families.push_back(GaugeOf("dcloc_map_cache_bytes",
                             "Size of the files in the cache, when it was looked at last",
                             static_cast<double>(counts.size_bytes)));
  families.push_back(GaugeOf("dcloc_map_cache_max_bytes", "The most that the cache takes",
                             static_cast<double>(cache.max_bytes())));
}

}  // namespace

void AddMapFileMetrics(const ObjectStore* objects, const MapCache* cache,
                       std::vector<prometheus::MetricFamily>& families) {
  if (objects != nullptr) AddObjects(*objects, families);
  if (cache != nullptr) AddCache(*cache, families);
}

}  // namespace dcloc::server
