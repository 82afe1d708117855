#include "core/relocalization/relocalizer.h"

#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

// A vehicle further than this from all keyframes has left the map; nearer than the other, it has
// come back.
constexpr double kOutside_m = 40.0;
constexpr double kBack_m = 20.0;

}  // namespace

template <int Dim>
std::optional<typename Relocalizer<Dim>::Place> Relocalizer<Dim>::Search(
    Stamp stamp, std::span<const GaussianPoint<Dim>> live, std::chrono::nanoseconds span,
    const std::optional<ExpectedPlace>& expected, RegistrationWorkspace<Dim>& workspace) {
  if (HasReturnedToMap()) global_.Clear();
  const auto min_point_count = static_cast<std::size_t>(
      expected ? options_.expected_gate.min_inlier_count : options_.gate.min_inlier_count);
  const bool sees_enough = span >= options_.min_view_span && live.size() >= min_point_count;
  if (sees_enough && global_.WantsView(stamp)) {
    // An expected place is held against those around it.
    const int growth = global_.failed_search_count() + (expected ? 1 : 0);
    global_.AddView(stamp, live, prior_.Region(growth, expected ? expected->min_radius_m : 0.0),
                    expected, MinConvincingScore());
  }
  std::optional<Place> place = global_.Continue(workspace);
  if (place) global_.Clear();
  return place;
}

// Searches in vain, while there was no map, say nothing of where the vehicle is now: the search
// begins anew, near where odometry has brought it.
template <int Dim>
bool Relocalizer<Dim>::HasReturnedToMap() {
  const std::optional<PoseEstimate<3>>& now = prior();
  const bool was_outside = std::exchange(
      is_outside_,
      now && !map_->NearestKeyframe(now->pose.translation_m, is_outside_ ? kBack_m : kOutside_m));
  return was_outside && now && !is_outside_;
}

// Nothing is known of a vehicle that begins: any score will do.
template <int Dim>
double Relocalizer<Dim>::MinConvincingScore() const {
  if (scores_.count < options_.min_usual_score_count) return 0.0;
  const double sigma = std::max(options_.min_usual_score_sigma, std::sqrt(scores_.variance));
  return scores_.mean - options_.convincing_score_sigmas * sigma;
}

template <int Dim>
void Relocalizer<Dim>::OnFix(const PoseEstimate<3>& T_map_vehicle) {
  const std::optional<PoseEstimate<3>>& prior = prior_.now();
  if (prior && global_.failed_search_count() == 0 &&
      HorizontalSigma(prior->covariance) <= HorizontalSigma(T_map_vehicle.covariance)) {
    return;
  }
  prior_.Set(T_map_vehicle);
}

template <int Dim>
void Relocalizer<Dim>::OnFound() {
  if (!prior_.now()) return;
  prior_.Reset();
  global_.Clear();
}

template class Relocalizer<2>;
template class Relocalizer<3>;

}  // namespace dcloc
