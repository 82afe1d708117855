#pragma once

#include <functional>
#include <string>

#include "absl/status/status.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/maps/store/map_store.h"

/// The calls that say which sessions get which version.
namespace dcloc::server {

/// Moves a map's running sessions to the version that each would get now; returns how many.
using SessionMover = std::function<int(const std::string& tenant, const std::string& map_name)>;

absl::Status Activate(MapStore& store, const SessionMover& move, const std::string& tenant,
                      const v1::ActivateMapVersionRequest& request,
                      v1::ActivateMapVersionResponse* response);

absl::Status RollBack(MapStore& store, const SessionMover& move, const std::string& tenant,
                      const v1::RollBackMapRequest& request, v1::RollBackMapResponse* response);

absl::Status SetCanary(MapStore& store, const std::string& tenant,
                       const v1::SetMapCanaryRequest& request, v1::Map* map);

}  // namespace dcloc::server
