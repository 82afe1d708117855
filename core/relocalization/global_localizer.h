#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/map/local_map.h"
#include "core/map/radar_map.h"
#include "core/odometry/motion.h"
#include "core/options/option_fields.h"
#include "core/registration/map_matcher.h"
#include "core/relocalization/place_search.h"

namespace dcloc {

/// What a place without a prior must reach.
struct GlobalLocalizerOptions {
  /// Of the winner; in each view somewhat less overlap is enough.
  RegistrationGate gate = {.min_inlier_count = 200, .min_overlap = 0.6};
  std::chrono::nanoseconds min_view_span = std::chrono::milliseconds(400);  ///< of a view's scans
  double min_distance_m = 10.0;  ///< it holds over so much way: standing still, all views agree
  double min_lead = 4.5;         ///< of its log-likelihood to that of every other place
  int candidate_count = 60;      ///< places that are tried for each view
};
std::span<const OptionField<GlobalLocalizerOptions>> FieldsOf(
    const GlobalLocalizerOptions& options);
absl::Status Validate(const GlobalLocalizerOptions& options);

/// Finds a vehicle of which nothing is known but a region, or not even that. Twice a second or so
/// it takes what the vehicle sees, a view, and searches for the places that fit like it. All
/// places found are registered with all views, joined by odometry, and contend: the one that fits
/// every view and all of them together better than any other by `min_lead`, and so for
/// `min_distance_m` of way, is where the vehicle is.
template <int Dim>
class GlobalLocalizer {
 public:
  GlobalLocalizer(std::shared_ptr<const RadarMap> map, const GlobalLocalizerOptions& options,
                  double local_map_radius_m, const GicpOptions& gicp)
      : map_(std::move(map)),
        options_(options),
        local_map_radius_m_(local_map_radius_m),
        gicp_(gicp) {}

  /// The vehicle moved so since the last call. Views that odometry no longer joins, as after a
  /// silence, are forgotten.
  void OnMotion(const Motion& motion);

  /// Whether all work is done and the vehicle has moved on, so that a new view says something new.
  bool WantsView(Stamp stamp) const;

  /// Begins to search the map, or a region of it, for what is seen now (vehicle frame). Only when
  /// `WantsView`.
  void AddView(Stamp stamp, std::span<const GaussianPoint<Dim>> live,
               const std::optional<SearchRegion>& region);

  /// Goes on with the work, for some ten milliseconds: others wait no longer, however large the
  /// map. Where the vehicle is now, once that is decided.
  std::optional<Pose3> Continue(RegistrationWorkspace<Dim>& workspace);

  /// There is work on a view left.
  bool working() const { return phase_ != Phase::kIdle; }

  /// Forgets everything, and gives back its memory.
  void Clear();

 private:
  // What was seen, and how the vehicle moved to there since the view before.
  struct View {
    std::vector<GaussianPoint<Dim>> live;
    std::vector<GaussianPoint<Dim>> coarse_points;  // of them, for a fit
    Motion motion;
    double way_m = 0.0;
  };
  // A place registered with a view.
  struct ViewFit {
    Pose3 T_map_vehicle;
    double log_likelihood = 0.0;
    bool is_acceptable = false;  // for a place without a prior
  };
  // A place that the search has found, registered with a coarse_points of the points.
  struct CoarseFit {
    Pose3 T_map_vehicle;
    double score = 0.0;
  };
  // A way on which the vehicle may have come: a fit for each view, filled one after the other.
  struct Candidate {
    std::vector<std::optional<ViewFit>> fits;
  };

  // The work on a view, in this order: candidates are registered with it, it is searched for other
  // places, those are registered with it, most of them at a fit, and then with the views before.
  enum class Phase { kIdle, kExtend, kSearch, kCoarseFit, kFineFit, kBackfill };

  void DoNextPiece(RegistrationWorkspace<Dim>& workspace);
  bool FillNextFit(RegistrationWorkspace<Dim>& workspace);
  void FitCoarsely(const PlaceHypothesis& place, RegistrationWorkspace<Dim>& workspace);
  void KeepPromising();
  void FitFinely(const CoarseFit& fit, RegistrationWorkspace<Dim>& workspace);
  void DropUnlikelyNewcomers();
  void KeepBestCandidates();
  std::optional<Pose3> Winner() const;
  double Way() const;
  static double LogLikelihood(const Candidate& candidate);
  ViewFit FitAfterMotion(const View& view, const ViewFit& beside, const Motion& motion,
                         RegistrationWorkspace<Dim>& workspace);
  ViewFit FitAround(const View& view, const Pose3& T_map_vehicle, double blur_m,
                    RegistrationWorkspace<Dim>& workspace);
  std::optional<Registration<Dim>> Register(std::span<const GaussianPoint<Dim>> live,
                                            const Pose3& T_map_vehicle, const GicpOptions& gicp,
                                            RegistrationWorkspace<Dim>& workspace);
  Pose3 InMap(const Pose<Dim>& T_local_vehicle) const;
  bool IsKnown(const Pose3& T_map_vehicle) const;

  std::optional<SearchRegion> region_;  // of the newest view
  std::optional<Pose3> winner_;         // T_map_vehicle at the newest view
  LocalMap<Dim> local_map_;
  std::optional<PlaceSearch> search_;
  Motion since_view_;          // since the newest view
  double since_view_m_ = 0.0;  // likewise, the way
  Stamp view_stamp_{};         // of the newest view
  double cell_m_ = 1.0;        // of the last search
  double work_ = 0.0;          // done by this call of Continue
  std::shared_ptr<const RadarMap> map_;
  std::optional<std::size_t> keyframe_;  // of local_map_
  std::vector<View> views_;              // oldest first
  std::vector<Candidate> candidates_;    // most likely first once all is done
  std::vector<PlaceHypothesis> places_;  // left to fit at, the best last
  std::vector<CoarseFit> coarse_fits_;   // left to fit at, likewise
  GlobalLocalizerOptions options_;
  double local_map_radius_m_;
  GicpOptions gicp_;
  int view_count_ = 0;  // since nothing is known
  Phase phase_ = Phase::kIdle;
};

}  // namespace dcloc
