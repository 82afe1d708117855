#pragma once

#include <nlohmann/json.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/sdk/map_client.h"
#include "dcloc/v1/map_service.pb.h"

namespace dcloc::cli {

/// A build that a server makes or has made: for scripts, and for people.
nlohmann::ordered_json BuildJson(const v1::MapBuild& build);
const char* StateText(const v1::MapBuild& build);
absl::Status PrintBuild(const v1::MapBuild& build, bool json);

/// Waits until a build has ended, with its stage on stderr, and prints its version. SIGINT and
/// SIGTERM cancel the build; a second one ends the waiting. The build's own error where it gave no
/// version.
absl::Status FollowBuild(client::MapClient& maps, const v1::MapBuild& started, bool json);

}  // namespace dcloc::cli
