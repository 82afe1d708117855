#pragma once

#include "google/protobuf/timestamp.pb.h"
#include "google/protobuf/util/time_util.h"
#include "server/base/clock.h"

namespace dcloc::server::convert {

inline google::protobuf::Timestamp ToProto(SystemTime time) {
  return google::protobuf::util::TimeUtil::NanosecondsToTimestamp(time.time_since_epoch().count());
}

}  // namespace dcloc::server::convert
