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
#include "core/registration/mapped_points.h"
#include "core/registration/observability.h"
#include "core/registration/registration_method.h"
#include "core/registration/registration_workspace.h"

namespace dcloc {

/// Gates of a registration: it is accepted if it passes all of them.
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

/// When the surroundings of a prediction are searched, and the gates of the result.
struct MapMatcherOptions {
  double local_map_radius_m = 100.0;
  GicpOptions gicp;
  RegistrationGate gate;
  ObservabilityOptions observability;
  /// Around predictions less certain than this, a correlative search precedes the registration.
  double search_sigma_m = 0.4;
  double search_sigma_rad = 0.03;
  int candidate_count = 4;
  /// For predictions less certain than `wide_sigma_m`, several places may look alike. Then
  /// `wide_candidate_count` places are registered. The best is accepted only if it has
  /// `wide_min_overlap`, if its log-posterior leads that of every other place by `wide_min_lead`,
  /// and if no other place fits the scans better. A place found by a search with less overlap than
  /// that must also lead so, whatever the prediction.
  double wide_sigma_m = 1.8;
  int wide_candidate_count = 10;
  double wide_min_overlap = 0.3;
  double wide_min_lead = 2.5;
  /// A search scores `search_point_count` points at every pose, on cells of `search_cell_m`. It
  /// reaches `search_sigmas` deviations of the prediction, at most `max_search_m` and
  /// `max_search_rad`.
  int search_point_count = 300;
  double search_cell_m = 0.25;
  double search_sigmas = 3.0;
  double max_search_m = 10.0;
  double max_search_rad = 0.8;
  double search_guess_sigma_m = 0.3;  ///< deviation of poses that a search finds: about a cell
  /// Number of points of a sub-map that count as independent: the weight of a score as evidence
  /// (METHOD eq 26).
  double independent_point_count = 20.0;
  double same_place_m = 1.0;  ///< results nearer to one another than this are the same place
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

  /// Loads the local map around `p_map`, in the frame of the nearest keyframe. True if the local
  /// frame has changed.
  bool MoveTo(const Eigen::Vector3d& p_map, RegistrationWorkspace<Dim>& workspace);

  /// Frame of the local map; the identity before the first MoveTo.
  const Pose3& T_map_local() const { return T_map_local_; }

  /// Registers `live` (vehicle frame) around the predicted pose. If the prediction is uncertain, a
  /// correlative search and descriptor matching give the initial guesses, except along directions
  /// that are not observed. Returns nothing if no pose passes the gates, or if a wide prediction
  /// leaves another place that is as good.
  std::optional<Registration<Dim>> Match(std::span<const GaussianPoint<Dim>> live,
                                         const PoseEstimate<Dim>& predicted,
                                         const Observability& observability, std::uint64_t seed,
                                         RegistrationWorkspace<Dim>& workspace);

  /// Registers `live` at the place that global localization found, and moves the local map there.
  /// Returns nothing if the result does not pass `gate`, the gate for poses without a prior.
  std::optional<Registration<Dim>> MatchFound(std::span<const GaussianPoint<Dim>> live,
                                              const Pose3& T_map_vehicle,
                                              const RegistrationGate& gate,
                                              RegistrationWorkspace<Dim>& workspace);

  /// The correspondences of `live` at a pose, one for each point that has one. `live` and
  /// `workspace` must be those of the preceding `Match`, and not used since. The result is valid
  /// until `workspace` is used again.
  std::span<const Correspondence<Dim>> Correspondences(std::span<const GaussianPoint<Dim>> live,
                                                       const Pose<Dim>& T_local_vehicle,
                                                       RegistrationWorkspace<Dim>& workspace) const;

  /// How well points (vehicle frame) lie in the map at a pose that is off by `sigma_m`; 0 without
  /// points or map.
  double Fit(std::span<const GaussianPoint<Dim>> points, const Pose<Dim>& T_local_vehicle,
             double sigma_m, RegistrationWorkspace<Dim>& workspace) const;

  /// The same with the vehicle at each of `T_vehicle_places` in the plane, to `fits`.
  void FitsAt(std::span<const Pose2> T_vehicle_places, std::span<const GaussianPoint<Dim>> points,
              const Pose<Dim>& T_local_vehicle, double sigma_m,
              RegistrationWorkspace<Dim>& workspace, std::vector<double>& fits) const;

  /// Where a registration of `live` puts a place, and its score. There is no gate.
  struct RegisteredPlace {
    Pose2 T_vehicle_place;
    double score = 0.0;
  };

  /// Registers `live` from `T_vehicle_place`, with the vehicle at `T_local_vehicle`.
  RegisteredPlace RegisterPlace(std::span<const GaussianPoint<Dim>> live,
                                const Pose<Dim>& T_local_vehicle, const Pose2& T_vehicle_place,
                                RegistrationWorkspace<Dim>& workspace) const;

  /// How many of the points lie where the map has landmarks; see `CountMappedPoints`.
  std::size_t CountMapped(std::span<const GaussianPoint<Dim>> points,
                          const Pose<Dim>& T_local_vehicle, double reach_m) const {
    return CountMappedPoints<Dim>(points, local_map_, T_local_vehicle, reach_m);
  }

  /// The directions in which a registration of `live` is observable.
  Observability Observed(std::span<const GaussianPoint<Dim>> live,
                         const Registration<Dim>& registration,
                         RegistrationWorkspace<Dim>& workspace) const;

 private:
  std::optional<Registration<Dim>> Search(std::span<const GaussianPoint<Dim>> live,
                                          const PoseEstimate<Dim>& predicted, bool wide,
                                          std::uint64_t seed,
                                          RegistrationWorkspace<Dim>& workspace);
  std::vector<Pose2> Candidates(std::span<const GaussianPoint<Dim>> live,
                                const PoseEstimate<Dim>& predicted, int count, std::uint64_t seed);
  CorrespondenceGates Gates() const;
  Registration<Dim> Refine(std::span<const GaussianPoint<Dim>> live, const Pose<Dim>& start,
                           double blur_m, RegistrationWorkspace<Dim>& workspace) const;

  // Data of the local map that only searches need. It is larger than the rest of a session.
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
