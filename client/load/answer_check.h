#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::load {

/// How a scan was sent.
enum class Sending {
  kOnce,
  kDuplicate,  ///< a second time, right behind the first
  kReordered,  ///< behind the one that follows it, so that it is late
};

/// A scan whose answer is due.
struct Expected {
  const v1::Scan* scan = nullptr;
  Sending sending = Sending::kOnce;
  bool resent = false;  ///< also on an earlier stream
};

/// The fault of an answer, if any: it belongs to another scan, stamp or map version, its pose is
/// invalid, the scan was localized twice, or it was late and localized nevertheless. A rejection
/// that the contract allows is no fault.
std::optional<std::string> FaultOf(const v1::LocalizeResponse& answer, const Expected& expected,
                                   std::int64_t map_version);

/// How far an answer is from the truth.
struct PositionError {
  double distance_m = 0.0;  ///< in the plane
  /// TRACKING, more than 2 m off, and with the truth outside of its 99.9 % ellipse.
  bool misleading = false;
};

/// Of a result that `FaultOf` found nothing wrong with. Nothing where it does not claim to know the
/// pose.
std::optional<PositionError> ErrorOf(const v1::LocalizationResult& result,
                                     const Eigen::Vector2d& true_position_m);

}  // namespace dcloc::load
