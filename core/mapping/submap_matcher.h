#pragma once

#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/pose_estimate.h"
#include "core/map/local_map.h"
#include "core/options/option_fields.h"
#include "core/registration/map_matcher.h"
#include "core/registration/registration_workspace.h"

namespace dcloc {

struct SubmapMatcherOptions {
  GicpOptions gicp;
  /// Errors that all landmarks of a sub-map share, by mounts, clocks and the ego-motion within it.
  double shared_sigma_m = 0.05;
  double shared_sigma_rad = 0.001;
  /// Around a guess less certain than this, a correlative search precedes the registration.
  double search_sigma_m = 0.5;
  double search_sigmas = 3.0;  ///< how far it reaches
  int candidate_count = 4;     ///< of its results that are registered
  int search_point_count = 250;
  /// Its cells: a window of any width is this many wide, within the bounds.
  double search_window_cells = 30.0;
  double max_search_cell_m = 1.0;
  double min_search_cell_m = 0.4;
};
std::span<const OptionField<SubmapMatcherOptions>> FieldsOf(const SubmapMatcherOptions& options);
absl::Status Validate(const SubmapMatcherOptions& options);

/// Two sub-maps of the same ground, one placed in the frame of the other.
struct SubmapMatch {
  PoseEstimate<2> T_target_live;  ///< the covariance holds what is not observed, and shared errors
  int inlier_count = 0;
  double overlap = 0.0;  ///< share of the live landmarks that are inliers
  double residual_scale = 0.0;
};

/// Where the live sub-map is expected to lie.
struct SubmapGuess {
  Pose2 T_target_live;
  double sigma_m = 0.1;
  double sigma_rad = 0.005;
};

/// Registers sub-maps of landmarks with one another by the localizer's own registration.
class SubmapMatcher {
 public:
  explicit SubmapMatcher(const SubmapMatcherOptions& options = {}) : options_(options) {}

  /// Registers `live` with `target` around the guess. Nothing where no pose passes `gate`.
  std::optional<SubmapMatch> Match(std::span<const GaussianPoint<2>> live,
                                   const LocalMap<2>& target, const SubmapGuess& guess,
                                   const RegistrationGate& gate);

 private:
  std::vector<Pose2> Starts(std::span<const GaussianPoint<2>> live, const LocalMap<2>& target,
                            const SubmapGuess& guess, double& start_sigma_m) const;

  SubmapMatcherOptions options_;
  RegistrationWorkspace<2> workspace_;
};

}  // namespace dcloc
