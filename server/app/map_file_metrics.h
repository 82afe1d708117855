#pragma once

#include <prometheus/metric_family.h>

#include <vector>

#include "server/maps/store/map_cache.h"
#include "server/objects/object_store.h"

namespace dcloc::server {

/// Adds what an object store of map files and a cache of them have counted; either may be null.
void AddMapFileMetrics(const ObjectStore* objects, const MapCache* cache,
                       std::vector<prometheus::MetricFamily>& families);

}  // namespace dcloc::server
