#include "server/maps/jobs/map_build.h"

#include <limits>
#include <utility>

#include "absl/strings/str_format.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/geometry.h"
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

absl::Status CheckMethod(v1::MapBuildMethod method) {
  switch (method) {
    case v1::MAP_BUILD_METHOD_UNSPECIFIED:
    case v1::MAP_BUILD_METHOD_KNOWN_POSES:
    case v1::MAP_BUILD_METHOD_SURVEY:
    case v1::MAP_BUILD_METHOD_UPDATE:
      return absl::OkStatus();
    default:
      return absl::InvalidArgumentError(absl::StrFormat(
          "header.method is %d, which this server does not know", static_cast<int>(method)));
  }
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

absl::Status NotTaken(absl::string_view field, v1::MapBuildMethod method, absl::string_view why) {
  const char* const what = method == v1::MAP_BUILD_METHOD_UPDATE ? "an update" : "a survey";
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is given; %s takes none: %s", field, what, why));
}

absl::StatusOr<BuildRequest> FromProto(const v1::MapBuildHeader& message) {
  absl::Status status = CheckMapName("header.map_name", message.map_name());
  status.Update(CheckMethod(message.method()));
  status.Update(CheckLength("header.drive_name", message.drive_name()));
  status.Update(CheckLength("header.description", message.description()));
  if (!status.ok()) return status;
  BuildRequest request{
      .rig = {},
      .options = {.name = message.drive_name(), .description = message.description()},
      .activate = message.activate()};
  const bool is_survey = message.method() == v1::MAP_BUILD_METHOD_SURVEY;
  const bool is_update = message.method() == v1::MAP_BUILD_METHOD_UPDATE;
  if (!is_update && message.base_version() != 0) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "header.base_version is %d; only an update has one", message.base_version()));
  }
  if (is_survey || is_update) {
    if (message.has_rig()) {
      return NotTaken("header.rig", message.method(), "each drive has its own");
    }
    if (message.has_anchor()) {
      return NotTaken("header.anchor", message.method(),
                      is_update ? "it keeps the base version's" : "its frame is its own");
    }
    status = CheckIntegerBetween("header.base_version", message.base_version(), 0,
                                 std::numeric_limits<std::int64_t>::max());
    if (!status.ok()) return status;
    request.base_version = message.base_version();
    return request;
  }
  absl::StatusOr<Rig> rig = convert::FromProto(message.rig(), "header.rig");
  if (!rig.ok()) return rig.status();
  request.rig = *std::move(rig);
  if (message.has_anchor()) {
    const absl::StatusOr<GeodeticAnchor> anchor = AnchorFromProto(message.anchor());
    if (!anchor.ok()) return anchor.status();
    request.options.anchor = *anchor;
  }
  status = WithPrefix("header: ", Validate(request.options));
  if (!status.ok()) return status;
  return request;
}

void ToProto(const BuildRow& row, v1::MapBuild* message) {
  message->ParseFromString(row.report);  // it was written by such a server
  message->set_build_id(row.build_id);
  message->set_map_name(row.map_name);
  message->set_state(ToProto(row.state));
  *message->mutable_create_time() = convert::ToProto(row.create_time);
  message->set_attempt_count(static_cast<std::int32_t>(row.attempt_count));
  if (row.state == BuildState::kRunning) return;
  message->clear_stage();
  message->clear_stage_share();
}

}  // namespace dcloc::server
