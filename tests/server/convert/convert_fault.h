#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/geometry/geodetic_anchor.h"
#include "server/convert/answer.h"
#include "server/convert/position_fix.h"
#include "server/convert/scan.h"
#include "server/convert/session.h"
#include "tests/server/fixtures/messages.h"

/// Messages that are spoiled in one place, and must be refused by its name.
namespace dcloc::server {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr float kInfinityF = std::numeric_limits<float>::infinity();

inline const GeodeticAnchor kAnchor{
    .origin = {.latitude_deg = 52.0, .longitude_deg = 8.0, .height_m = 100.0},
    .x_axis_east_rad = 0.3};

inline Rig FrontRig() {
  v1::Rig message;
  *message.add_radars() = RadarMessage("front");
  return *convert::FromProto(message, "rig");
}

inline absl::Status Convert(const v1::Scan& message) {
  Scan scan;
  return convert::FromProto(message, FrontRig(), &scan);
}

inline absl::Status Convert(const v1::OpenSession& message) {
  if (auto request = convert::FromProto(message); !request.ok()) return request.status();
  return convert::InitialPoseFromProto(message, kAnchor).status();
}

inline absl::Status Convert(const v1::PositionFix& message) {
  return convert::FromProto(message, kAnchor).status();
}

/// Something wrong, and what the error must name.
template <typename Message>
struct Fault {
  const char* name;
  std::function<void(Message*)> spoil;
  std::vector<std::string> named;
};

template <typename Message>
void ExpectRefused(const Fault<Message>& fault, Message message) {
  fault.spoil(&message);
  const absl::Status status = Convert(message);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << fault.name << ": " << status;
  for (const std::string& part : fault.named) {
    EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr(part)) << fault.name;
  }
}

template <typename Message>
std::string FaultName(const ::testing::TestParamInfo<Fault<Message>>& info) {
  return info.param.name;
}

}  // namespace dcloc::server
