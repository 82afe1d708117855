#include "core/localizability/alias_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/registration/gicp_registration.h"
#include "core/relocalization/place_search.h"
#include "core/relocalization/view.h"

namespace dcloc {
namespace {

// As well as it takes to compare places.
constexpr RegistrationEffort kEffort{
    .max_iterations = 15, .translation_tolerance_m = 0.005, .rotation_tolerance_rad = 0.0005};
constexpr double kGuessSigma_m = 0.3;  // of a place that motion leads to
// Views that tell a tunnel. A return that lies on a landmark of a wall speaks for the place that
// made it, and with each view more.
constexpr std::size_t kTunnelViews = 2;
constexpr std::array kTunnelShares = {-1.0, -0.6, -0.3, 0.3, 0.6, 1.0};  // of `tunnel_m`
constexpr std::size_t kMinTunnelPlaces = 2;                              // of these
constexpr double kCellSigma_m = 1.0;  // of a place that a search finds: about a cell

}  // namespace

std::span<const OptionField<AliasOptions>> FieldsOf(const AliasOptions& /*options*/) {
  using O = AliasOptions;
  static constexpr OptionField<O> kFields[] = {
      {"radius_m", &O::radius_m, 0, 1e7, "places are not held against others"},
      {"candidate_count", &O::candidate_count, 1, 1000},
      {"local_map_radius_m", &O::local_map_radius_m, 10, 1000},
      {"min_distance_m", &O::min_distance_m, 0.5, 100},
      {"min_turn_rad", &O::min_turn_rad, 0.1, std::numbers::pi},
      {"tunnel_m", &O::tunnel_m, 3, 100},
      {"min_overlap", &O::min_overlap, 0, 1, "any overlap is enough"},
      {"log_likelihood_per_score", &O::log_likelihood_per_score, 1, 1000},
      {"min_lead", &O::min_lead, 0, 1000, "only what fits better is an alias"},
  };
  return kFields;
}

absl::Status Validate(const AliasOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

AliasFinder::AliasFinder(std::shared_ptr<const RadarMap> map, const AliasOptions& options)
    : map_(std::move(map)),
      options_(options),
      registrar_(map_, std::make_shared<GicpRegistration<2>>(GicpOptions{}),
                 options.local_map_radius_m) {}

PlaceLikeness AliasFinder::Find(std::span<const PlaceView> views) {
  if (options_.radius_m == 0.0 || views.empty() || views.front().points.empty()) return {};
  const Pose3& T_map_vehicle = views.front().T_map_vehicle;
  const std::optional<Fit> right = FitAll(views, T_map_vehicle, kGuessSigma_m);
  if (!right) return {};
  PlaceLikeness likeness{.is_tunnel = IsTunnel(views.first(std::min(kTunnelViews, views.size())))};
  for (const Pose3& T_map_candidate : Candidates(views.front())) {
    if (IsSamePlace(T_map_vehicle.Inverse() * T_map_candidate)) continue;
    const std::optional<Fit> other = FitAll(views, T_map_candidate, kCellSigma_m);
    if (!other || LeadOf(*right, *other) >= options_.min_lead) continue;
    const Pose3 T_vehicle_other = T_map_vehicle.Inverse() * other->T_map_vehicle;
    if (IsSamePlace(T_vehicle_other) || (likeness.is_tunnel && IsAlongTheWay(T_vehicle_other))) {
      continue;
    }
    if (!likeness.alias || LeadOf(*right, *other) < likeness.alias->lead) {
      likeness.alias = {.T_map_vehicle = other->T_map_vehicle, .lead = LeadOf(*right, *other)};
    }
  }
  return likeness;
}

/// What is seen fits at several places along the way as it fits here. Where something stands, it
/// fits at none or at one, or registration finds the way back.
bool AliasFinder::IsTunnel(std::span<const PlaceView> views) {
  const Pose3& T_map_vehicle = views.front().T_map_vehicle;
  const std::optional<Fit> right = FitAll(views, T_map_vehicle, kGuessSigma_m);
  if (!right) return false;
  std::size_t count = 0;
  for (const double share : kTunnelShares) {
    const Pose3 T_vehicle_there = Embed({{share * options_.tunnel_m, 0.0}, 0.0});
    const std::optional<Fit> fit = FitAll(views, T_map_vehicle * T_vehicle_there, kCellSigma_m);
    if (!fit || LeadOf(*right, *fit) >= options_.min_lead) continue;
    const Pose3 T_vehicle_found = T_map_vehicle.Inverse() * fit->T_map_vehicle;
    if (IsAlongTheWay(T_vehicle_found) && !IsSamePlace(T_vehicle_found)) ++count;
  }
  return count >= kMinTunnelPlaces;
}

double AliasFinder::LeadOf(const Fit& right, const Fit& other) const {
  return options_.log_likelihood_per_score * (right.score - other.score);
}

std::vector<Pose3> AliasFinder::Candidates(const PlaceView& view) const {
  PlaceSearchOptions options{.cell_m = kCellSigma_m, .max_count = options_.candidate_count};
  options.region = SearchRegion{.centre_m = view.T_map_vehicle.translation_m.head<2>(),
                                .radius_m = options_.radius_m,
                                .yaw_rad = 0.0,
                                .max_yaw_offset_rad = std::numbers::pi};
  PlaceSearch search(map_, PositionsOf<2>(view.points), options);
  while (!search.done()) search.SearchOn();
  std::vector<Pose3> candidates;
  for (const PlaceCandidate& place : search.Best()) {
    candidates.push_back(map_->keyframe(place.keyframe).T_map_keyframe *
                         Embed(place.T_keyframe_vehicle));
  }
  return candidates;
}

std::optional<AliasFinder::Fit> AliasFinder::FitAll(std::span<const PlaceView> views,
                                                    const Pose3& T_map_first,
                                                    double guess_sigma_m) {
  Fit fit{.T_map_vehicle = T_map_first};
  for (const PlaceView& view : views) {
    const bool is_first = &view == views.data();
    const Pose3 T_first_view = views.front().T_map_vehicle.Inverse() * view.T_map_vehicle;
    const auto found =
        registrar_.Register(view.points, fit.T_map_vehicle * T_first_view,
                            is_first ? guess_sigma_m : kGuessSigma_m, kEffort, workspace_);
    if (!found || found->registration.overlap < options_.min_overlap) return std::nullopt;
    if (is_first) fit.T_map_vehicle = found->T_map_vehicle;
    fit.score += found->registration.score;
  }
  return fit;
}

bool AliasFinder::IsSamePlace(const Pose3& T_a_b) const {
  return T_a_b.translation_m.head<2>().norm() < options_.min_distance_m &&
         std::abs(Yaw(T_a_b.rotation)) < options_.min_turn_rad;
}

bool AliasFinder::IsAlongTheWay(const Pose3& T_a_b) const {
  return std::abs(T_a_b.translation_m.x()) <= options_.tunnel_m &&
         std::abs(T_a_b.translation_m.y()) < options_.min_distance_m &&
         std::abs(Yaw(T_a_b.rotation)) < options_.min_turn_rad;
}

}  // namespace dcloc
