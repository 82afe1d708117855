#pragma once

#include "absl/status/statusor.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/maps/jobs/map_builds.h"

namespace dcloc::server {

/// The build that a client asks for, without the tenant and the limits. InvalidArgument names the
/// field.
absl::StatusOr<BuildRequest> FromProto(const v1::MapBuildHeader& message);

/// A build as the client is told of it.
void ToProto(const BuildRecord& record, v1::MapBuild* message);

}  // namespace dcloc::server
