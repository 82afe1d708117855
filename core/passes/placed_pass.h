#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/localizer/localizer.h"
#include "core/map/radar_map.h"
#include "core/odometry/ego_motion.h"
#include "core/passes/beyond_map.h"
#include "core/passes/scan_worth.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/radar/static_points.h"

namespace dcloc {

/// One scan of a pass, where the localizer put it in the base map.
struct PlacedScan {
  Stamp stamp{};
  std::size_t radar = 0;  ///< index in the rig
  Pose3 T_map_vehicle;
  Pose2 T_start_vehicle;           ///< by odometry alone, from where the pass began
  double sigma_m = 0.0;            ///< of the horizontal position, the larger axis
  int inlier_count = 0;            ///< of the registration that the pose rests on
  bool is_good = false;            ///< counts: tracked for a while, and with sound sources; or
                                   ///< beyond the map
  bool is_beyond_map = false;      ///< counts, and is placed by odometry alone: `PlaceBeyondMap`
  std::vector<RadarPoint> points;  ///< static targets, vehicle frame
};

/// Which scans are taken, of those that count.
enum class ScanChoice { kAll, kTracked, kBeyondMap };
bool IsChosen(const PlacedScan& scan, ScanChoice choice);

/// A drive over the map.
struct PlacedPass {
  std::string name;
  std::string vehicle;  ///< passes of one vehicle on one day are one witness
  Rig rig;
  std::vector<PlacedScan> scans;
  std::size_t refused_count = 0;    ///< scans that the localizer did not take
  std::string first_refusal;        ///< why
  std::size_t untracked_count = 0;  ///< scans without a tracked pose, or soon after there was none
  std::size_t unsure_count = 0;     ///< whose pose was too uncertain
  std::size_t unsound_count = 0;    ///< while a source was set aside
  SourceFault fault = SourceFault::kNone;  ///< of the source that was set aside last
  double length_m = 0.0;                   ///< driven, by odometry

  /// Scans that count and were tracked in the map.
  std::size_t GoodCount() const;
  /// Scans that count and were taken beyond the map.
  std::size_t BeyondCount() const;
};

/// What makes a pass useless for an update, and why; empty where it is of use. It moved too little,
/// its stamps were refused, it was not tracked in the map, or its sources contradict one another.
std::string FaultOf(const PlacedPass& pass);

struct PassPlacerOptions {
  LocalizerOptions localizer;
  ScanWorthOptions worth;
  BeyondMapOptions beyond_map;
};

/// Localizes a pass in the base map, scan by scan, and keeps what an update needs of it.
class PassPlacer {
 public:
  /// Without a prior: the whole map is searched. InvalidArgument names what is wrong with the rig.
  static absl::StatusOr<PassPlacer> Create(std::shared_ptr<const RadarMap> map, std::string name,
                                           std::string vehicle, Rig rig,
                                           const PassPlacerOptions& options = {});

  /// The next scan. One that the localizer refuses is counted and left out.
  void Add(const Scan& scan);

  PlacedPass Finish() &&;

 private:
  PassPlacer(std::shared_ptr<const RadarMap> map, Localizer localizer, PlacedPass pass,
             const PassPlacerOptions& options);

  PassPlacerOptions options_;
  std::shared_ptr<const RadarMap> map_;
  Localizer localizer_;
  EgoMotion ego_motion_;
  Pose3 T_start_vehicle_;
  std::unique_ptr<Rig> rig_;  ///< where ego-motion may point to
  ScanJudge judge_;
  PlacedPass pass_;
};

/// A vehicle on a day: what passes of it say is one testimony.
using Witness = std::pair<std::string, long>;

/// When the first scan of `pass` that counts was taken. At least one does.
Stamp FirstGoodStamp(const PlacedPass& pass);

Witness WitnessOf(const PlacedPass& pass);

/// Of each pass, the first one of the same witness.
std::vector<std::size_t> FirstOfWitness(std::span<const PlacedPass> passes);

}  // namespace dcloc
