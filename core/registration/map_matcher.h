#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/pose_estimate.h"
#include "core/map/local_map.h"
#include "core/map/radar_map.h"
#include "core/options/option_fields.h"
#include "core/registration/correlative_search.h"
#include "core/registration/gicp.h"
#include "core/registration/observability.h"
#include "core/registration/registration_method.h"
#include "core/registration/registration_workspace.h"

namespace dcloc {

/// What a registration must reach to be accepted.
struct RegistrationGate {
  int min_inlier_count = 10;
  double min_overlap = 0.2;
  double max_residual_scale = 1.8;

  template <int Dim>
  bool Accepts(const Registration<Dim>& registration) const {
    return registration.inlier_count >= min_inlier_count && registration.overlap >= min_overlap &&
           registration.residual_scale <= max_residual_scale;
  }
};
std::span<const OptionField<RegistrationGate>> FieldsOf(const RegistrationGate& options);
absl::Status Validate(const RegistrationGate& options);

/// When a prediction is searched around, and what the result must reach.
struct MapMatcherOptions {
  double local_map_radius_m = 100.0;
  GicpOptions gicp;
  RegistrationGate gate;
  /// Predictions less certain than this are searched around before refinement.
  double search_sigma_m = 0.4;
  double search_sigma_rad = 0.03;
  int hypotheses = 4;
  /// Predictions less certain than this may leave several places that look alike. More of them are
  /// tried, and the best is accepted only with this overlap, when its log-posterior leads that of
  /// every other place by so much, and when none fits the scans better. With less overlap a place
  /// that was searched for must so stand out whatever the prediction.
  double wide_sigma_m = 1.8;
  int wide_hypotheses = 10;
  double wide_min_overlap = 0.3;
  double wide_min_lead = 2.5;
  /// A search scores so many points at every pose, on cells of this size, up to so many deviations
  /// of the prediction away, and no further than this.
  int search_point_count = 300;
  double search_cell_m = 0.25;
  double search_sigmas = 3.0;
  double max_search_m = 10.0;
  double max_search_rad = 0.8;
  double search_guess_sigma_m = 0.3;  ///< of what a search finds: about a cell
  /// So many points of a sub-map are as good as independent: what a score is worth as evidence
  /// (METHOD eq 26).
  double independent_point_count = 20.0;
  double same_place_m = 1.0;  ///< results nearer to one another are the same place
};
std::span<const OptionField<MapMatcherOptions>> FieldsOf(const MapMatcherOptions& options);
absl::Status Validate(const MapMatcherOptions& options);

/// Matches live sub-maps with the part of the map around the vehicle.
template <int Dim>
class MapMatcher {
 public:
  MapMatcher(std::shared_ptr<const RadarMap> map,
             std::shared_ptr<const RegistrationMethod<Dim>> method,
             const MapMatcherOptions& options)
      : map_(std::move(map)), method_(std::move(method)), options_(options) {}

  /// Makes the local map the one around `p_map`, in the frame of the keyframe nearest to it. True
  /// when that changed the local frame.
  bool MoveTo(const Eigen::Vector3d& p_map, RegistrationWorkspace<Dim>& workspace);

  /// Frame of the local map; the identity before the first MoveTo.
  const Pose3& T_map_local() const { return T_map_local_; }

  /// Registers `live` (vehicle frame) around the predicted pose: refinement alone where the
  /// prediction is good, after a correlative search and descriptor matching where it is not, except
  /// in directions in which there is nothing to be found.
  /// Nothing when no pose is acceptable, and when a wide prediction leaves another place that is as
  /// good.
  std::optional<Registration<Dim>> Match(std::span<const GaussianPoint<Dim>> live,
                                         const PoseEstimate<Dim>& predicted,
                                         const Observability& observability, std::uint64_t seed,
                                         RegistrationWorkspace<Dim>& workspace);

  /// Registers `live` where a search found the vehicle, which becomes the place of the local map.
  /// Nothing when it does not pass `gate`, which is that of poses without a prior.
  std::optional<Registration<Dim>> MatchFound(std::span<const GaussianPoint<Dim>> live,
                                              const Pose3& T_map_vehicle,
                                              const RegistrationGate& gate,
                                              RegistrationWorkspace<Dim>& workspace);

  /// The landmarks that `live` corresponds to at a pose, one for each point that has one. `live`
  /// and `workspace` are those of the Match before, and not used since; valid as long.
  std::span<const Correspondence<Dim>> Correspondences(std::span<const GaussianPoint<Dim>> live,
                                                       const Pose<Dim>& T_local_vehicle,
                                                       RegistrationWorkspace<Dim>& workspace) const;

  /// How well points (vehicle frame) lie in the map at a pose that is off by `sigma_m`: the mean of
  /// exp(-d^2 / 2), 0 of those without a correspondence; 0 without points or map.
  double Fit(std::span<const GaussianPoint<Dim>> points, const Pose<Dim>& T_local_vehicle,
             double sigma_m, RegistrationWorkspace<Dim>& workspace) const;

  /// In which directions a registration of `live` says something.
  Observability Observed(std::span<const GaussianPoint<Dim>> live,
                         const Registration<Dim>& registration,
                         RegistrationWorkspace<Dim>& workspace) const;

 private:
  std::optional<Registration<Dim>> Search(std::span<const GaussianPoint<Dim>> live,
                                          const PoseEstimate<Dim>& predicted, bool wide,
                                          std::uint64_t seed,
                                          RegistrationWorkspace<Dim>& workspace);
  std::vector<Pose2> Hypotheses(std::span<const GaussianPoint<Dim>> live,
                                const PoseEstimate<Dim>& predicted, int count, std::uint64_t seed);
  CorrespondenceGates Gates() const;
  Registration<Dim> Refine(std::span<const GaussianPoint<Dim>> live, const Pose<Dim>& start,
                           double blur_m, RegistrationWorkspace<Dim>& workspace);

  // What a search needs of the local map, larger than all else that a session holds.
  struct SearchAids {
    LikelihoodField field;
    std::vector<Eigen::Vector2f> landmarks;
    Eigen::MatrixXf descriptors;  // of the landmarks
  };

  std::shared_ptr<const RadarMap> map_;
  std::shared_ptr<const RegistrationMethod<Dim>> method_;
  MapMatcherOptions options_;
  std::optional<std::size_t> keyframe_;
  Pose3 T_map_local_;
  LocalMap<Dim> local_map_;
  std::optional<SearchAids> search_;  // of local_map_, while predictions are uncertain
};

}  // namespace dcloc
