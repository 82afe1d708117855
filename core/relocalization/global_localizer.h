#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/map/radar_map.h"
#include "core/odometry/motion.h"
#include "core/relocalization/global_localizer_options.h"
#include "core/relocalization/place_registration.h"
#include "core/relocalization/place_search.h"
#include "core/relocalization/view.h"

namespace dcloc {

/// Whether a place was known before the search: by a prior or a pose that it verified.
enum class PlaceOrigin { kExpected, kFound };

/// Finds a vehicle of which nothing is known but a region, or not even that. Twice a second or so
/// the sub-map is kept as a view, and the map is searched for places that look like it. All places
/// found are registered with all views, joined by odometry. The pose is the one that fits every
/// view acceptably, leads all others in log-likelihood over all views by `min_lead`, and does so
/// over `min_distance_m` travelled (METHOD eq 38). A place at which the vehicle is expected takes
/// part, and one view may decide for it.
template <int Dim>
class GlobalLocalizer {
 public:
  /// Why a place is expected.
  enum class Basis {
    kPrior,   ///< it stands unless another is clearly better
    kSuspect  ///< it must be as good as any other
  };
  /// Where the vehicle is by a prior or by a doubted pose.
  struct ExpectedPlace {
    Pose3 T_map_vehicle;  ///< now
    Basis basis = Basis::kPrior;
    double min_radius_m = 0.0;  ///< it is held against all places within this, at least
  };
  /// Where the vehicle is.
  struct Place {
    Pose3 T_map_vehicle;
    PlaceOrigin origin = PlaceOrigin::kFound;
    bool fits_as_usual = false;  ///< it scores as registrations did where the vehicle surely was
  };

  GlobalLocalizer(std::shared_ptr<const RadarMap> map,
                  std::shared_ptr<const RegistrationMethod<Dim>> method, double local_map_radius_m,
                  const GlobalLocalizerOptions& options)
      : map_(std::move(map)),
        method_(std::move(method)),
        local_map_radius_m_(local_map_radius_m),
        options_(options),
        registrar_(map_, method_, local_map_radius_m) {}

  /// The vehicle moved so since the last call. Views that odometry no longer joins, as after a
  /// silence, are forgotten. `spread`, the part of the covariance by which the sources of odometry
  /// differ, does not count for that: one of them joins the views, and they show whether it is
  /// right.
  void OnMotion(const Motion& motion, const Matrix6d& spread = Matrix6d::Zero());

  /// Whether all work is done and the vehicle has moved on, so that a new view says something new.
  bool WantsView(Stamp stamp) const;

  /// Begins to search the map, or a region of it, for what is seen now (vehicle frame), beside
  /// where it is expected. A place that scores less than `min_convincing_score` is right only if
  /// the whole map has no better one; 0 where the vehicle never knew its place. Only when
  /// `WantsView`.
  void AddView(Stamp stamp, std::span<const GaussianPoint<Dim>> live,
               const std::optional<SearchRegion>& region,
               const std::optional<ExpectedPlace>& expected = {},
               double min_convincing_score = 0.0);

  /// Goes on with the work, for some ten milliseconds: others wait no longer, however large the
  /// map. Where the vehicle is now, once that is decided.
  std::optional<Place> Continue(RegistrationWorkspace<Dim>& workspace);

  /// What the views show is not where it was put: they are taken anew. The search counts on.
  void RetakeViews();

  /// How often, since all was forgotten, no place has been found that fits what is seen.
  int failed_search_count() const { return failed_search_count_; }

  /// There is work on a view left.
  bool working() const { return phase_ != Phase::kIdle; }

  /// Forgets everything, and gives back its memory.
  void Clear();

 private:
  // A view registered at a place.
  struct ViewFit {
    Pose3 T_map_vehicle;
    double log_likelihood = 0.0;
    bool is_acceptable = false;
    bool is_plausible = false;   // enough for an expected place in the whole map
    bool is_close = false;       // overlaps as what is seen of a known place does
    bool is_convincing = false;  // enough for one without the whole map
    bool is_as_usual = false;    // scores as registrations of this vehicle did
  };
  // A place that the search has found, registered with a view's coarse points.
  struct CoarseFit {
    Pose3 T_map_vehicle;
    double score = 0.0;
  };
  // A path on which the vehicle may have come: a fit for each view, filled one after the other.
  struct Candidate {
    std::vector<std::optional<ViewFit>> fits;
    bool is_expected = false;
  };

  // The work on a view, in this order: candidates are registered with it; the map is searched for
  // other places; those are fitted coarsely; the best of them finely, as new candidates; these are
  // registered with the views before.
  enum class Phase { kIdle, kExtend, kSearch, kCoarseFit, kFineFit, kBackfill };

  void DoNextPiece(RegistrationWorkspace<Dim>& workspace);
  void EndSearch();
  bool FillNextFit(RegistrationWorkspace<Dim>& workspace);
  void FitCoarsely(const PlaceCandidate& place, RegistrationWorkspace<Dim>& workspace);
  void KeepPromisingFits();
  void FitFinely(const CoarseFit& fit, RegistrationWorkspace<Dim>& workspace);
  void DropOldestView();
  std::chrono::nanoseconds ViewInterval() const;
  bool FitsSomewhere(std::size_t view, bool ViewFit::*quality) const;
  void DropViewsOfElsewhere();
  void DropUnlikelyNewCandidates();
  void KeepBestCandidates();
  void AddExpected(RegistrationWorkspace<Dim>& workspace);
  static bool HoldsInAll(bool ViewFit::*quality, const Candidate& candidate);
  bool StandsOut(const Candidate& candidate) const;
  bool IsExpectedRight(const Candidate& expected) const;
  bool IsInVain() const;
  std::optional<Place> Winner() const;
  double DistanceTravelled() const;
  static double LogLikelihood(const Candidate& candidate);
  ViewFit FitAfterMotion(const View<Dim>& view, const ViewFit& neighbour, const Motion& motion,
                         RegistrationWorkspace<Dim>& workspace);
  ViewFit FitAround(const View<Dim>& view, const Pose3& T_map_vehicle,
                    RegistrationWorkspace<Dim>& workspace);
  double SquaredDistance(const Pose<Dim>& difference, const TangentMatrix<Dim>& odometry) const;
  bool IsSamePlace(const Pose3& a, const Pose3& b) const;
  bool IsKnown(const Pose3& T_map_vehicle) const;

  std::shared_ptr<const RadarMap> map_;
  std::shared_ptr<const RegistrationMethod<Dim>> method_;
  double local_map_radius_m_;
  GlobalLocalizerOptions options_;
  PlaceRegistrar<Dim> registrar_;

  Phase phase_ = Phase::kIdle;
  int view_count_ = 0;                   // taken since there was no pose
  std::vector<View<Dim>> views_;         // oldest first
  Stamp view_stamp_{};                   // of the newest view
  double travelled_since_view_m_ = 0.0;  // likewise
  std::optional<SearchRegion> region_;   // likewise
  Motion since_view_;                    // likewise
  Motion noise_since_view_;              // the same without the spread of the sources
  std::optional<PlaceSearch> search_;
  double cell_m_ = 1.0;                    // of the last search
  std::vector<PlaceCandidate> places_;     // left to be fitted coarsely, the best last
  std::vector<CoarseFit> coarse_fits_;     // left to be fitted finely, likewise
  std::vector<Candidate> candidates_;      // most likely first once all is done
  std::optional<ExpectedPlace> expected_;  // at the newest view
  double min_convincing_score_ = 0.0;      // likewise
  std::optional<Place> winner_;            // likewise
  int failed_search_count_ = 0;
  bool newest_fits_ = false;  // the newest view, somewhere in the map
  double work_ = 0.0;         // done by this call of Continue
};

}  // namespace dcloc
