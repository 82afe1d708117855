#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/map/map_builder.h"
#include "core/radar/radar_model.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/maps/catalogue/build_queue.h"

namespace dcloc::server {

/// What a build's header asks for.
struct BuildRequest {
  Rig rig;  ///< of a survey or an update it is empty: each drive has its own
  MapBuilderOptions options;
  bool activate = false;
  std::int64_t base_version = 0;  ///< of an update
};

/// InvalidArgument names the field.
absl::StatusOr<BuildRequest> FromProto(const v1::MapBuildHeader& message);

/// InvalidArgument: `field` is of no use to a build of another method, and why.
absl::Status NotTaken(absl::string_view field, v1::MapBuildMethod method, absl::string_view why);

/// A build as the client is told of it.
void ToProto(const BuildRow& row, v1::MapBuild* message);

}  // namespace dcloc::server
