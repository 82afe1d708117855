#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/localizer/localizer_options.h"
#include "core/map/local_map.h"
#include "core/map/radar_map.h"
#include "core/posegraph/pose_graph.h"
#include "core/registration/correlative_search.h"
#include "core/registration/gicp.h"
#include "core/registration/observability.h"

namespace dcloc {

/// Matches live sub-maps with the part of the map around the vehicle.
template <int Dim>
class MapMatcher {
 public:
  MapMatcher(std::shared_ptr<const RadarMap> map, const LocalizerOptions& options)
      : map_(std::move(map)), options_(options) {}

  /// Makes the local map the one around `p_map`, in the frame of the keyframe nearest to it. True
  /// when that changed the local frame.
  bool MoveTo(const Eigen::Vector3d& p_map);

  /// Frame of the local map; the identity before the first MoveTo.
  const Pose3& T_map_local() const { return T_map_local_; }

  /// Registers `live` (vehicle frame) around the predicted pose: refinement alone where the
  /// prediction is good, after a correlative search and descriptor matching where it is not, except
  /// in directions in which there is nothing to be found.
  /// Nothing when no pose is believable, and when a wide prediction leaves another place that is as
  /// good.
  std::optional<Registration<Dim>> Match(std::span<const GaussianPoint<Dim>> live,
                                         const PoseEstimate<Dim>& predicted,
                                         const Observability& observability, std::uint64_t seed);

  /// Registers `live` where a search found the vehicle, which becomes the place of the local map.
  /// Nothing when that is not believable without a prior.
  std::optional<Registration<Dim>> MatchFound(std::span<const GaussianPoint<Dim>> live,
                                              const Pose3& T_map_vehicle);

  /// The landmarks that the points given to Match match at a pose. To be called on the thread that
  /// Match was called on, before any other vehicle's, while the points are there; valid as long.
  std::span<const Correspondence<Dim>> Matches(const Pose<Dim>& T_local_vehicle) const;

  /// In which directions a registration of `live` says something.
  Observability Observed(std::span<const GaussianPoint<Dim>> live,
                         const Registration<Dim>& registration) const;

 private:
  std::optional<Registration<Dim>> Search(std::span<const GaussianPoint<Dim>> live,
                                          const PoseEstimate<Dim>& predicted, bool wide,
                                          std::uint64_t seed);
  std::vector<Pose2> Hypotheses(std::span<const GaussianPoint<Dim>> live,
                                const PoseEstimate<Dim>& predicted, int count, std::uint64_t seed);
  Registration<Dim> Refine(std::span<const GaussianPoint<Dim>> live, const Pose<Dim>& start,
                           double blur_m);
  bool IsAcceptable(const Registration<Dim>& registration) const;

  // What a search needs of the local map, larger than all else that a session holds.
  struct SearchAids {
    LikelihoodField field;
    std::vector<Eigen::Vector2f> landmarks;
    Eigen::MatrixXf descriptors;  // of the landmarks
  };

  std::shared_ptr<const RadarMap> map_;
  LocalizerOptions options_;
  std::optional<std::size_t> keyframe_;
  Pose3 T_map_local_;
  LocalMap<Dim> local_map_;
  std::optional<SearchAids> search_;  // of local_map_, while predictions are uncertain
};

}  // namespace dcloc
