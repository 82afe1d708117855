#pragma once

#include <map>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/localizer/localizer.h"
#include "core/localizer/localizer_options.h"
#include "core/odometry/ego_motion.h"
#include "core/radar/radar_model.h"
#include "core/submap/submap.h"

namespace dcloc {

/// What the compared methods have in common up to registration: checks, ego-motion, static points,
/// sub-map.
class FrontEnd {
 public:
  /// With `ego_range_rates`, targets are compensated by the range rates that the ego-motion gives
  /// them instead of the measured ones, which then tell no movers either.
  FrontEnd(Rig rig, const LocalizerOptions& options, bool ego_range_rates)
      : rig_(std::move(rig)),
        options_(options),
        ego_range_rates_(ego_range_rates),
        ego_motion_(options.ego_motion),
        window_(options.scans_per_submap) {}

  /// The sub-map that ends with `scan`; the first stages are announced to `listener`, if any.
  /// InvalidArgument as of `Localizer::Localize`.
  absl::StatusOr<Submap> Add(const Scan& scan, StageListener* listener);

  /// From the scan before the last one to the last one.
  const Motion& since_previous() const { return ego_motion_.since_previous(); }

  /// True when a registration of `submap` is due, by the rules of our own pipeline: not before
  /// there is enough of a sub-map, and not more often than `registration_interval`.
  bool RegistrationIsDue(Stamp stamp, const Submap& submap);

 private:
  absl::Status CheckOrder(const Scan& scan) const;

  Rig rig_;
  LocalizerOptions options_;
  bool ego_range_rates_;
  EgoMotion ego_motion_;
  SubmapWindow window_;
  std::map<std::string, Stamp> last_stamp_of_radar_;
  std::optional<Stamp> last_stamp_;
  std::optional<Stamp> last_registration_;
};

}  // namespace dcloc
