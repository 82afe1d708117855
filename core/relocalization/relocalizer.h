#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "core/geometry/forgetting_mean.h"
#include "core/relocalization/global_localizer.h"
#include "core/relocalization/pose_prior.h"

namespace dcloc {

/// Finds a vehicle that has no pose, near where it may be and, after that has been in vain, ever
/// further away; and holds a pose that may be wrong against other places.
template <int Dim>
class Relocalizer {
 public:
  using Place = typename GlobalLocalizer<Dim>::Place;
  using ExpectedPlace = typename GlobalLocalizer<Dim>::ExpectedPlace;

  Relocalizer(std::shared_ptr<const RadarMap> map,
              std::shared_ptr<const RegistrationMethod<Dim>> method, double local_map_radius_m,
              const PosePriorOptions& prior_options, const GlobalLocalizerOptions& options)
      : options_(options),
        map_(map),
        prior_(prior_options),
        global_(std::move(map), std::move(method), local_map_radius_m, options) {}

  /// Where the vehicle may be, carried on by odometry; absent where nothing is known.
  const std::optional<PoseEstimate<3>>& prior() const { return prior_.now(); }
  void SetPrior(const PoseEstimate<3>& T_map_vehicle) { prior_.Set(T_map_vehicle); }

  /// Something else than radar says where the vehicle is. It replaces a prior that is less certain,
  /// and one around which the vehicle has been searched for in vain.
  void OnFix(const PoseEstimate<3>& T_map_vehicle);

  /// Whether registrations can start from a pose that is known so well, without a search.
  bool IsPrediction(const Matrix6d& covariance) const { return prior_.IsPrediction(covariance); }

  /// The vehicle moved so. `spread` is the part of the covariance by which the sources of odometry
  /// differ, and not their noise (METHOD eq 49).
  void OnMotion(const Motion& motion, const Matrix6d& spread = Matrix6d::Zero()) {
    prior_.OnMotion(motion);
    global_.OnMotion(motion, spread);
  }

  /// Goes on searching for what is seen now: `live`, in the vehicle frame, of the last ones of
  /// scans that have come for `span`. An expected place is held against the others. Gives the place
  /// where the vehicle is once that is decided, and forgets the views that led there.
  std::optional<Place> Search(Stamp stamp, std::span<const GaussianPoint<Dim>> live,
                              std::chrono::nanoseconds span,
                              const std::optional<ExpectedPlace>& expected,
                              RegistrationWorkspace<Dim>& workspace);

  /// Where the vehicle surely is, a registration has this score.
  void OnRegistered(double score) { scores_.Add(score, options_.score_forgetting_factor); }

  /// What was seen so far may not have been of the place where the vehicle is.
  void ForgetViews() { global_.Clear(); }

  /// What views show is not where it was put. They are taken anew, and the search goes on.
  void RetakeViews() { global_.RetakeViews(); }

  /// How many searches since the last `ForgetViews` found nothing that fits.
  int failed_search_count() const { return global_.failed_search_count(); }

  /// The vehicle has been found: there is nothing to search for.
  void OnFound();

 private:
  double MinConvincingScore() const;
  bool HasReturnedToMap();

  GlobalLocalizerOptions options_;
  std::shared_ptr<const RadarMap> map_;
  PosePrior prior_;
  GlobalLocalizer<Dim> global_;
  ForgettingMean scores_;    // of registrations
  bool is_outside_ = false;  // of what the map's drive passed, by the prior
};

}  // namespace dcloc
