#include "server/convert/map.h"

#include "google/protobuf/util/time_util.h"
#include "server/convert/geometry.h"
#include "server/identity/principal.h"

namespace dcloc::server::convert {
namespace {

using google::protobuf::util::TimeUtil;

void SetInfo(const MapInfo& info, v1::MapInfo* message) {
  message->set_drive_name(info.name);
  message->set_description(info.description);
  message->set_keyframe_count(static_cast<std::int64_t>(info.keyframe_count));
  message->set_point_count(static_cast<std::int64_t>(info.point_count));
  message->set_length_m(info.length_m);
  ToProto(info.min_map_m, message->mutable_min_map_m());
  ToProto(info.max_map_m, message->mutable_max_map_m());
  message->set_has_elevation(info.has_elevation);
  if (info.anchor) ToProto(*info.anchor, message->mutable_anchor());
}

}  // namespace

void ToProto(const MapRecord& record, v1::Map* message) {
  message->set_name(std::string(UnscopedMapName(record.name)));
  message->set_active_version(record.active_version);
  message->set_version_count(record.version_count);
  *message->mutable_create_time() =
      TimeUtil::NanosecondsToTimestamp(record.create_time.time_since_epoch().count());
}

void ToProto(const MapVersionRecord& record, v1::MapVersion* message) {
  message->set_map_name(std::string(UnscopedMapName(record.map_name)));
  message->set_version(record.version);
  message->set_active(record.active);
  message->set_size_bytes(static_cast<std::int64_t>(record.info.size_bytes));
  message->set_sha256(record.sha256);
  *message->mutable_create_time() =
      TimeUtil::NanosecondsToTimestamp(record.create_time.time_since_epoch().count());
  SetInfo(record.info, message->mutable_info());
}

}  // namespace dcloc::server::convert
