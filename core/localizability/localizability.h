#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/localizability/alias_finder.h"
#include "core/localizability/expected_drive.h"
#include "core/map/keyframe_accuracy.h"
#include "core/map/radar_map.h"
#include "core/options/option_fields.h"

namespace dcloc {

struct LocalizabilityOptions {
  /// By default it has one radar, which looks ahead.
  ExpectedVehicle vehicle = DefaultVehicle();
  AliasOptions aliases;
  double min_observed_share = 0.5;  ///< of answers that observe the way; fewer are a tunnel's
  std::uint64_t seed = 1;

  static ExpectedVehicle DefaultVehicle();
};
std::span<const OptionField<LocalizabilityOptions>> FieldsOf(const LocalizabilityOptions& options);
absl::Status Validate(const LocalizabilityOptions& options);

/// How well a vehicle that comes along the mapped way knows where it is, at a keyframe.
struct KeyframeLocalizability {
  /// A vehicle was there and had a pose. Else the deviations mean nothing.
  bool is_known = false;
  // Deviations that the vehicle is told, in its own frame.
  double along_sigma_m = 0.0;
  double across_sigma_m = 0.0;
  double heading_sigma_rad = 0.0;
  double tracking_share = 0.0;  ///< of its answers there that were TRACKING
  bool is_tunnel = false;       ///< radars do not observe the way along
  std::optional<Alias> alias;   ///< a vehicle without a pose may take it for this place
};

/// The same, as a map file holds it.
KeyframeAccuracy AccuracyOf(const KeyframeLocalizability& keyframe);

/// Gets the share that is done; returning false ends the work with Cancelled.
using LocalizabilityProgress = std::function<bool(double share)>;

/// The localizability of each keyframe, in their order. A vehicle drives along the keyframes and
/// sees what the map holds (`ExpectedDrive`); `Localizer` localizes it. So its covariance is what a
/// vehicle is told, with all that the method knows of odometry, noise and unobserved directions. It
/// drives twice: once to learn, and once to tell. Each keyframe is held against the places around
/// it (`AliasFinder`). InvalidArgument names what is wrong with the options or the rig.
absl::StatusOr<std::vector<KeyframeLocalizability>> ComputeLocalizability(
    const std::shared_ptr<const RadarMap>& map, const LocalizabilityOptions& options,
    const LocalizabilityProgress& progress);

}  // namespace dcloc
