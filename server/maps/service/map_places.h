#pragma once

#include <string>

#include "absl/status/status.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/maps/store/map_store.h"

/// The calls that ask for coverage and tiles.
namespace dcloc::server {

absl::Status FindCoverage(MapStore& store, const std::string& tenant,
                          const v1::FindCoverageRequest& request,
                          v1::FindCoverageResponse* response);

absl::Status ReadMapTile(MapStore& store, const std::string& tenant,
                         const v1::ReadMapTileRequest& request, v1::ReadMapTileResponse* response);

}  // namespace dcloc::server
