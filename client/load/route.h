#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::load {

/// A drive as vehicles send it, made once and shared by all that drive it.
struct Route {
  std::string name;
  std::vector<v1::Scan> scans;  ///< by ascending stamp; sequence numbers are indices
  std::vector<Eigen::Vector2d> true_positions_m;  ///< in the map, one for each scan; may be empty
  /// What opens a session that begins with scan `first`; `seed` differs from trip to trip.
  std::function<v1::OpenSession(std::size_t first, std::uint64_t seed)> open;
};

}  // namespace dcloc::load
