#include "client/cli/common/anchor_option.h"

#include <string>
#include <vector>

#include "core/geometry/degrees.h"

namespace dcloc::cli {

CLI::Option* AddAnchorOption(CLI::App& command, std::optional<GeodeticAnchor>& anchor) {
  const auto take = [&anchor](const std::vector<double>& values) {
    GeodeticAnchor given{.origin = {.latitude_deg = values[0], .longitude_deg = values[1]}};
    if (values.size() > 2) given.origin.height_m = values[2];
    if (values.size() > 3) given.x_axis_east_rad = values[3] * kRadPerDeg;
    if (const absl::Status status = Validate(given); !status.ok()) {
      throw CLI::ValidationError("--anchor", std::string(status.message()));
    }
    anchor = given;
  };
  return command
      .add_option_function<std::vector<double>>(
          "--anchor", take,
          "Where the drive's frame lies on the Earth: latitude and longitude [deg] of its origin,\n"
          "its height [m], and how far its x axis is turned counter-clockwise from east [deg];\n"
          "the last two are 0 if not given")
      ->delimiter(',')
      ->expected(2, 4)
      ->type_name("LAT,LON,H,DEG");
}

}  // namespace dcloc::cli
