#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/datasets/fix_file.h"
#include "client/simulation/simulation.h"

namespace dcloc {

/// Holds `<pass>.csv` with the pass's position fixes where there are any (fix_file.h).
inline constexpr const char* kFixFolder = "fixes";

/// Beside the tables, where the world has aged.
inline constexpr const char* kChangesFileName = "dcloc_changes.json";

/// Writes simulated drives in the official nuScenes layout, which the public devkit reads:
/// `v1.0-sim/` with all tables, `samples/` and `sweeps/` with radar sweeps, `maps/` with a blank
/// raster, and the CAN bus expansion's `can_bus/<pass>_pose.json`. Each pass is a scene of its name
/// and a log of its own day.
///
/// Beside the tables lies `dcloc_rig.json`, for what nuScenes has no place for:
///   `radars`: RadarModel's fields of each radar (beta_s, sigmas, ...), which our reader takes
///   over; `simulation`: the options that everything was made from.
///
/// ego_pose is the exact truth. can_bus has what wheels and gyroscope measured (`vel`,
/// `rotation_rate`), and the truth as `pos`, `orientation`, `accel`.
class NuScenesWriter {
 public:
  /// Makes `root` ready. FailedPrecondition when it holds something else than an earlier simulation
  /// (which is removed), unless `force`: then files are added to what is there.
  static absl::StatusOr<NuScenesWriter> Create(const std::filesystem::path& root, bool force);

  NuScenesWriter(NuScenesWriter&&) noexcept;
  NuScenesWriter& operator=(NuScenesWriter&&) noexcept;
  ~NuScenesWriter();

  /// Writes the pass's sweeps and bus log; its table rows wait for `Finish`.
  absl::Status AddPass(const SimulatedPass& pass);

  /// Writes the pass's position fixes into kFixFolder.
  absl::Status AddFixes(const std::string& pass_name, const std::vector<StampedFix>& fixes);

  /// Writes what live passes see otherwise than the map pass, beside the tables: scatterers that
  /// came and went, and the vehicles that stood at the kerb in each pass added so far.
  absl::Status AddChanges(const std::vector<simulation::ScattererChange>& changes);

  /// Writes the tables. Without it the folder is not a data set.
  absl::Status Finish(const SimulationOptions& options);

 private:
  struct Tables;
  NuScenesWriter(std::filesystem::path root, std::unique_ptr<Tables> tables);

  std::filesystem::path root_;
  std::unique_ptr<Tables> tables_;
};

}  // namespace dcloc
