#pragma once

#include <vector>

#include "client/simulation/motion/traffic.h"
#include "client/simulation/radar/occlusion.h"
#include "client/simulation/radar/radar_profile.h"
#include "client/simulation/radar/radar_view.h"
#include "client/simulation/radar/scene.h"

namespace dcloc::simulation {

/// Where an echo comes from.
enum class EchoSource {
  kStatic,        ///< a persistent scatterer, parked vehicles included
  kGlint,         ///< a wall that is seen at a right angle; slides along the wall with the vehicle
  kMoving,        ///< a moving vehicle
  kReflection,    ///< off a smooth wall: from elsewhere in every scan
  kMirror,        ///< ghost: another echo seen over a wall, behind the wall
  kDoubleBounce,  ///< ghost: twice between the target and the ego vehicle
  kClutter,       ///< nothing persistent: ground, rain, interference
};

/// One echo, exact, before it is measured.
struct Echo {
  EchoSource source = EchoSource::kStatic;
  Eigen::Vector3d p_map;  ///< where it appears to be
  Eigen::Vector3d velocity_map_mps = Eigen::Vector3d::Zero();
  Observation observation;
  double rcs_dbsm = 0.0;
  double snr_db = 0.0;   ///< above the detection threshold
  std::uint32_t id = 0;  ///< of its scatterer; 0 without one
};

/// Gain over a target of the same RCS straight ahead at the reference range, one scan's two-way
/// power; minus infinity outside of the radar's field of view.
double BeamGainDb(const RadarProfile& profile, const Observation& observation);

/// RCS of `scatterer` (facing in the map) for a radar in the direction `aspect_rad` from it: its
/// sector's taper (power falls as a cosine) and its own fixed lobes; minus infinity outside its
/// sector.
double AspectRcsDbsm(const Scatterer& scatterer, double aspect_rad);

/// All echoes that the radar could detect: of everything in `scene` and `bodies` that is above the
/// detection threshold and not hidden, without ghosts and clutter. `occlusion` holds the walls of
/// both.
std::vector<Echo> CollectEchoes(const Scene& scene, const std::vector<MovingBody>& bodies,
                                const Occlusion& occlusion, const RadarView& view,
                                const RadarProfile& profile, Random& random);

/// The walls that can hide something from the radar at `view`.
Occlusion CollectOcclusion(const Scene& scene, const std::vector<MovingBody>& bodies,
                           const RadarView& view, const RadarProfile& profile);

}  // namespace dcloc::simulation
