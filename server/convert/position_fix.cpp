#include "server/convert/position_fix.h"

#include <string>

#include "server/base/check.h"
#include "server/convert/initial_pose.h"
#include "server/convert/scan.h"

namespace dcloc::server::convert {
namespace {

v1::FixUse UseOf(FixUse use) {
  switch (use) {
    case FixUse::kFused:
    case FixUse::kConsistentNotFused:  // the contract has one value for both
      return v1::FIX_USE_FUSED;
    case FixUse::kGuidesSearch:
      return v1::FIX_USE_GUIDES_SEARCH;
    case FixUse::kContradicted:
      return v1::FIX_USE_CONTRADICTED;
    case FixUse::kOutOfTime:
      return v1::FIX_USE_OUT_OF_TIME;
  }
  return v1::FIX_USE_UNSPECIFIED;
}

v1::FixUse UseOf(const absl::StatusOr<FixUse>& use) {
  if (use.ok()) return UseOf(*use);
  return absl::IsResourceExhausted(use.status()) ? v1::FIX_USE_OVER_LIMIT : v1::FIX_USE_INVALID;
}

}  // namespace

absl::StatusOr<PositionFix> FromProto(const v1::PositionFix& message,
                                      const std::optional<GeodeticAnchor>& anchor) {
  if (absl::Status status = CheckStamp("position_fix.stamp_ns", message.stamp_ns()); !status.ok()) {
    return status;
  }
  if (message.position_case() == v1::PositionFix::POSITION_NOT_SET) {
    return Missing("position_fix.position");
  }
  absl::StatusOr<InitialPose> pose =
      message.has_map_pose() ? FromProto(message.map_pose(), "position_fix.map_pose")
                             : FromProto(message.gnss_fix(), anchor, "position_fix.gnss_fix");
  if (!pose.ok()) return pose.status();
  return PositionFix{.stamp = Stamp(std::chrono::nanoseconds(message.stamp_ns())),
                     .pose = *std::move(pose)};
}

void ToProto(const FixAnswer& answer, v1::PositionFixAnswer* message) {
  message->set_stamp_ns(answer.stamp_ns);
  message->set_use(UseOf(answer.use));
  message->set_message(std::string(answer.use.status().message()));
}

}  // namespace dcloc::server::convert
