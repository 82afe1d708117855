#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "client/cli/common/dataset_options.h"
#include "client/cli/common/trajectory_options.h"
#include "client/evaluation/perturbation.h"
#include "client/sdk/channel.h"
#include "core/geometry/geodetic_anchor.h"

namespace dcloc::cli {

/// What `dcloc localize` was asked for, as it was written.
struct LocalizeArguments {
  client::ChannelOptions server;
  std::string map;
  std::string vehicle = "dcloc-localize";
  DatasetArguments dataset;
  DriveRequest drive;
  std::string ego_velocity = "sensor";
  std::string initial = "truth";
  std::optional<GeodeticAnchor> anchor;  ///< of the drive's frame, for an initial GNSS fix
  Perturbation perturbation;
  std::string rate = "realtime";
  std::optional<int> scans_per_submap;
  double reconnect_s = 30.0;  ///< 0: never
  std::string csv_file;
  std::string tum_file;
  TrajectoryArguments trajectory;
  std::string fix_file;          ///< position fixes to send; may be empty
  std::string learned_rig_file;  ///< what was learned, read and kept; may be empty
  std::string record_file;       ///< of the session; may be empty
  bool json = false;
};

/// Sends the drive's scans to the server, writes its answers, and prints how good they were. An
/// error also when the session ended early or was interrupted; the files then hold what was
/// answered.
absl::Status RunLocalize(const LocalizeArguments& arguments);

}  // namespace dcloc::cli
