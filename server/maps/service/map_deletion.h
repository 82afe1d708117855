#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/maps/store/map_store.h"
#include "server/passes/pass_store.h"

/// The calls that delete versions and maps, and drain their sessions if asked to.
namespace dcloc::server {

/// Drains a tenant's sessions from a version of a map (0: from all versions): moves those that can
/// continue in another version and ends the others, or ends all.
struct SessionDrainer {
  using Drain = std::function<void(const std::string& tenant, const std::string& map_name,
                                   std::int64_t version)>;
  Drain move_or_end;
  Drain end_all;
};

/// May wait for some seconds when sessions are to be drained.
absl::Status DeleteVersion(MapStore& store, const SessionDrainer& drainer,
                           const std::string& tenant, const v1::DeleteMapVersionRequest& request);

/// As above; the map's consent to keep passes goes with it, and the passes.
absl::Status DeleteMap(MapStore& store, PassStore& passes, const SessionDrainer& drainer,
                       const std::string& tenant, const v1::DeleteMapRequest& request);

}  // namespace dcloc::server
