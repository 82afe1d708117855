#include "core/localizer/localizer_options.h"

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

absl::Status CheckBetween(const char* field, double value, double min, double max) {
  if (value >= min && value <= max) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %g; it must lie in [%g, %g]", field, value, min, max));
}

double Milliseconds(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

}  // namespace

absl::Status Validate(const LocalizerOptions& options) {
  absl::Status status = CheckBetween("scans_per_submap", options.scans_per_submap, 1, 100);
  status.Update(CheckBetween("pose_graph.window", options.pose_graph.window, 1, 1000));
  status.Update(CheckBetween("registration_interval_ms",
                             Milliseconds(options.registration_interval), 0.0, 10'000.0));
  status.Update(
      CheckBetween("match.local_map_radius_m", options.match.local_map_radius_m, 10.0, 1000.0));
  status.Update(CheckBetween("match.max_live_points", options.match.max_live_points, 10, 100'000));
  status.Update(CheckBetween("gicp.max_iterations", options.gicp.max_iterations, 1, 1000));
  status.Update(CheckBetween("gicp.reach_m", options.gicp.reach_m, 0.1, 20.0));
  status.Update(CheckBetween("static_points.max_range_m", options.static_points.max_range_m,
                             options.static_points.min_range_m, 1000.0));
  return status;
}

}  // namespace dcloc
