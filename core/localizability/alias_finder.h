#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/radar_map.h"
#include "core/options/option_fields.h"
#include "core/registration/registration_workspace.h"
#include "core/relocalization/place_registration.h"

namespace dcloc {

struct AliasOptions {
  /// Places within this distance are held against one another; 0: none are.
  double radius_m = 500.0;
  int candidate_count = 12;  ///< places that are registered
  double local_map_radius_m = 100.0;
  double min_distance_m = 3.0;  ///< nearer poses are the same place
  double min_turn_rad = 0.5;    ///< unless they look elsewhere by more than this
  /// Between smooth walls a place looks like those a little before and behind it: by this at most.
  double tunnel_m = 20.0;
  double min_overlap = 0.5;  ///< of what is seen, for a place to be taken for another
  /// Log-likelihood of a score of 1, and the lead that tells places apart: those of
  /// `GlobalLocalizerOptions` (METHOD eq 38).
  double log_likelihood_per_score = 36.0;
  double min_lead = 4.5;
};
std::span<const OptionField<AliasOptions>> FieldsOf(const AliasOptions& options);
absl::Status Validate(const AliasOptions& options);

/// What is seen at a place.
struct PlaceView {
  Pose3 T_map_vehicle;
  std::vector<GaussianPoint<2>> points;  ///< vehicle frame
};

/// Another place that looks like one.
struct Alias {
  Pose3 T_map_vehicle;  ///< of a vehicle that is taken to be there
  /// By how much the right place leads it in log-likelihood, over all views; negative where the
  /// other one fits better.
  double lead = 0.0;
};

/// What a place looks like.
struct PlaceLikeness {
  bool is_tunnel = false;      ///< like places a little before or behind it
  std::optional<Alias> alias;  ///< the place elsewhere that is most like it
};

/// Holds places of a map against all others nearby, as a vehicle without a pose has to.
class AliasFinder {
 public:
  /// `options` are valid.
  AliasFinder(std::shared_ptr<const RadarMap> map, const AliasOptions& options);

  /// The places that the views do not tell from this one. The first view is of the place, the
  /// others of where a vehicle comes next, as far as it drives before it decides.
  PlaceLikeness Find(std::span<const PlaceView> views);

 private:
  struct Fit {
    Pose3 T_map_vehicle;  // at the first view
    double score = 0.0;   // summed over views
  };
  bool IsTunnel(std::span<const PlaceView> views);
  std::vector<Pose3> Candidates(const PlaceView& view) const;
  /// The sum over all views, with the first one at a pose; nothing where one does not fit.
  std::optional<Fit> FitAll(std::span<const PlaceView> views, const Pose3& T_map_first,
                            double guess_sigma_m);
  double LeadOf(const Fit& right, const Fit& other) const;
  bool IsSamePlace(const Pose3& T_a_b) const;
  bool IsAlongTheWay(const Pose3& T_a_b) const;

  std::shared_ptr<const RadarMap> map_;
  AliasOptions options_;
  PlaceRegistrar<2> registrar_;
  RegistrationWorkspace<2> workspace_;
};

}  // namespace dcloc
