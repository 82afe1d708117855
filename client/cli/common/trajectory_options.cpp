#include "client/cli/common/trajectory_options.h"

#include <span>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/common/atomic_file.h"
#include "client/trajectory/trajectory_format.h"
#include "client/trajectory/trajectory_writer.h"

namespace dcloc::cli {

CLI::Option* AddTrajectoryOptions(CLI::App& command, TrajectoryArguments& arguments) {
  std::vector<std::string> names;
  names.reserve(kTrajectoryFormatNames.size());
  for (const auto& [name, format] : kTrajectoryFormatNames) names.emplace_back(name);
  CLI::Option* out =
      command
          .add_option("--trajectory-out", arguments.file,
                      "Write the poses in the map: .tum, .kitti, .csv, .geojson or .gpx")
          ->type_name("FILE");
  command
      .add_option("--trajectory-format", arguments.format,
                  "Of --trajectory-out, where its extension does not tell")
      ->check(CLI::IsMember(names))
      ->needs(out);
  return out;
}

absl::Status CheckTrajectory(const TrajectoryArguments& arguments, bool has_anchor) {
  if (arguments.file.empty()) return absl::OkStatus();
  const auto format = TrajectoryFormatOf(arguments.file, arguments.format);
  if (!format.ok()) return format.status();
  if (!NeedsAnchor(*format) || has_anchor) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(arguments.file,
                   ": needs places on the Earth, and the map has no anchor; write .tum, .kitti or "
                   ".csv, or give the map an anchor"));
}

absl::Status WriteTrajectory(const TrajectoryArguments& arguments, const Trajectory& trajectory) {
  if (arguments.file.empty()) return absl::OkStatus();
  const auto format = TrajectoryFormatOf(arguments.file, arguments.format);
  if (!format.ok()) return format.status();
  if (trajectory.poses.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat(arguments.file, ": is not written, as there is no pose in the map"));
  }
  const absl::StatusOr<std::string> text = FormatTrajectory(trajectory, *format);
  if (!text.ok()) return text.status();
  return WriteFileAtomically(arguments.file, std::as_bytes(std::span(*text)));
}

}  // namespace dcloc::cli
