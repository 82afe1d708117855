#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/map/map_frame.h"

namespace dcloc::cli {

/// Control points of a CSV file: a header, then a line each with the columns x_m, y_m (in the map),
/// latitude_deg, longitude_deg and, where it is known, height_m. Errors name the file and the line.
absl::StatusOr<std::vector<ControlPoint>> ReadControlPoints(const std::string& file);

}  // namespace dcloc::cli
