#pragma once

#include <Eigen/Core>

#include "core/geometry/geodetic_anchor.h"
#include "core/geometry/pose.h"
#include "dcloc/v1/geometry.pb.h"

namespace dcloc::cli {

/// A pose's covariance as it is on the wire, row by row.
using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

// Plain values of messages that a server has accepted or made.

inline Eigen::Vector3d VectorOf(const v1::Vector3& message) {
  return {message.x(), message.y(), message.z()};
}

/// The rotation as it is on the wire, to the last bit.
inline Pose3 PoseOf(const v1::Pose& message) {
  const v1::Quaternion& q = message.rotation();
  return {.translation_m = VectorOf(message.translation_m()),
          .rotation = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z())};
}

inline GeodeticPosition PositionOf(const v1::GeodeticPosition& message) {
  return {.latitude_deg = message.latitude_deg(),
          .longitude_deg = message.longitude_deg(),
          .height_m = message.height_m()};
}

}  // namespace dcloc::cli
