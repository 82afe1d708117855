#include "client/cli/session/recorded_trajectory.h"

#include <optional>

#include "absl/strings/str_cat.h"
#include "client/cli/remote/wire.h"
#include "client/sdk/recording.h"

namespace dcloc::cli {

absl::StatusOr<std::size_t> WriteRecordedTrajectory(const std::string& file,
                                                    const TrajectoryArguments& arguments) {
  absl::StatusOr<client::RecordingReader> recording = client::RecordingReader::Open(file);
  if (!recording.ok()) return recording.status();
  const v1::RecordingHeader& header = recording->header();
  absl::Status status = CheckTrajectory(arguments, header.opened().has_anchor());
  if (!status.ok()) return status;
  Trajectory trajectory{.name = header.open().vehicle_id(), .anchor = std::nullopt, .poses = {}};
  if (header.opened().has_anchor()) trajectory.anchor = FromProto(header.opened().anchor());
  while (true) {
    const auto entry = recording->Next();
    if (!entry.ok()) return entry.status();
    if (!entry->has_value()) break;
    if (!(*entry)->has_scan() || !(*entry)->scan().answer().has_result()) continue;
    const absl::StatusOr<Localization> answer = FromProto((*entry)->scan().answer().result());
    if (!answer.ok()) {
      return absl::Status(answer.status().code(),
                          absl::StrCat(file, ": ", answer.status().message()));
    }
    if (answer->state == LocalizationState::kInitializing) continue;
    trajectory.poses.push_back({answer->stamp, answer->T_map_vehicle});
  }
  SortByStamp(trajectory.poses);
  status = WriteTrajectory(arguments, trajectory);
  if (!status.ok()) return status;
  return trajectory.poses.size();
}

}  // namespace dcloc::cli
