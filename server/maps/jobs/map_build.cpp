#include "server/maps/jobs/map_build.h"

#include "absl/strings/str_format.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/geometry.h"
#include "server/convert/map.h"
#include "server/convert/scan.h"
#include "server/convert/time.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxDescription = 1000;

absl::Status CheckLength(absl::string_view field, const std::string& text) {
  if (text.size() <= kMaxDescription) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat("%s has %d bytes; it may have at most %d",
                                                    field, text.size(), kMaxDescription));
}

absl::StatusOr<GeodeticAnchor> AnchorFromProto(const v1::GeodeticAnchor& message) {
  const absl::StatusOr<GeodeticPosition> origin =
      convert::FromProto(message.origin(), "header.anchor.origin");
  if (!origin.ok()) return origin.status();
  const GeodeticAnchor anchor{.origin = *origin, .x_axis_east_rad = message.x_axis_east_rad()};
  absl::Status status = WithPrefix("header.anchor: ", Validate(anchor));
  if (!status.ok()) return status;
  return anchor;
}

v1::MapBuildState ToProto(BuildState state) {
  switch (state) {
    case BuildState::kRunning:
      return v1::MAP_BUILD_STATE_RUNNING;
    case BuildState::kDone:
      return v1::MAP_BUILD_STATE_DONE;
    case BuildState::kFailed:
      return v1::MAP_BUILD_STATE_FAILED;
    case BuildState::kCancelled:
      return v1::MAP_BUILD_STATE_CANCELLED;
  }
  return v1::MAP_BUILD_STATE_UNSPECIFIED;
}

}  // namespace

absl::StatusOr<BuildRequest> FromProto(const v1::MapBuildHeader& message) {
  absl::Status status = CheckMapName("header.map_name", message.map_name());
  status.Update(CheckLength("header.drive_name", message.drive_name()));
  status.Update(CheckLength("header.description", message.description()));
  if (!status.ok()) return status;
  absl::StatusOr<Rig> rig = convert::FromProto(message.rig(), "header.rig");
  if (!rig.ok()) return rig.status();
  BuildRequest request{
      .map_name = message.map_name(),
      .rig = *std::move(rig),
      .options = {.name = message.drive_name(), .description = message.description()},
      .activate = message.activate()};
  if (message.has_anchor()) {
    const absl::StatusOr<GeodeticAnchor> anchor = AnchorFromProto(message.anchor());
    if (!anchor.ok()) return anchor.status();
    request.options.anchor = *anchor;
  }
  status = WithPrefix("header: ", Validate(request.options));
  if (!status.ok()) return status;
  return request;
}

void ToProto(const BuildRecord& record, v1::MapBuild* message) {
  message->set_build_id(record.build_id);
  message->set_map_name(record.map_name);
  message->set_state(ToProto(record.state));
  message->set_scan_count(record.scan_count);
  message->set_done_scan_count(record.done_scan_count);
  *message->mutable_create_time() = convert::ToProto(record.create_time);
  message->set_error_code(static_cast<std::int32_t>(record.error.code()));
  message->set_error_message(std::string(record.error.message()));
  if (record.version) convert::ToProto(*record.version, message->mutable_version());
}

}  // namespace dcloc::server
