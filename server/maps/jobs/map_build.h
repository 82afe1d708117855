#pragma once

#include "absl/status/statusor.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/maps/jobs/map_builds.h"

namespace dcloc::server::convert {

/// All but the tenant and the limits.
absl::StatusOr<BuildRequest> FromProto(const v1::MapBuildHeader& message);

void ToProto(const BuildRecord& record, v1::MapBuild* message);

}  // namespace dcloc::server::convert
