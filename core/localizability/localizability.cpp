#include "core/localizability/localizability.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/localizability/keyframe_path.h"

namespace dcloc {
namespace {

constexpr std::size_t kViewCount = 3;  // over some twenty metres

void Tell(const AnswerSum& sum, double min_observed_share, KeyframeLocalizability& result) {
  if (sum.posed_count == 0) return;
  const Vector6d sigma = (sum.variance / sum.posed_count).cwiseSqrt();
  result.is_known = true;
  result.along_sigma_m = sigma(0);
  result.across_sigma_m = sigma(1);
  result.heading_sigma_rad = sigma(5);
  result.tracking_share = static_cast<double>(sum.tracking_count) / sum.count;
  if (sum.observed_count < min_observed_share * sum.posed_count) result.is_tunnel = true;
}

/// What is seen from a keyframe on; at the end of the stretch, before it.
std::vector<PlaceView> ViewsFrom(const std::vector<PlaceView>& all, std::size_t index) {
  std::vector<PlaceView> views = {all[index]};
  for (std::size_t i = index + 1; i < all.size() && views.size() < kViewCount; ++i) {
    views.push_back(all[i]);
  }
  for (std::size_t i = index; i > 0 && views.size() < kViewCount; --i) views.push_back(all[i - 1]);
  return views;
}

/// One computation. What the vehicle has learned on the longest stretch so far, it knows on others.
class Computation {
 public:
  Computation(const std::shared_ptr<const RadarMap>& map, const LocalizabilityOptions& options)
      : map_(map),
        options_(options),
        aliases_(map, options.aliases),
        result_(map->info().keyframe_count) {}

  absl::StatusOr<std::vector<KeyframeLocalizability>> Run(const LocalizabilityProgress& progress) {
    std::vector<Stretch> stretches = StretchesOf(*map_);
    std::ranges::stable_sort(stretches, [](const Stretch& a, const Stretch& b) {
      return a.end - a.begin > b.end - b.begin;
    });
    for (const Stretch& stretch : stretches) {
      if (absl::Status status = Look(stretch, progress); !status.ok()) return status;
    }
    return std::move(result_);
  }

 private:
  absl::Status Look(const Stretch& stretch, const LocalizabilityProgress& progress) {
    const std::uint64_t seed = options_.seed + stretch.begin;
    ExpectedDrive first(map_, stretch, options_.vehicle, {}, seed);
    if (absl::Status status = first.Run(learned_); !status.ok()) return status;
    if (!learned_) learned_ = first.learned();
    if (absl::Status status = FindLikeness(stretch, first.views(), progress); !status.ok()) {
      return status;
    }
    // Once more, now that it has learned, and that it is known where walls show nothing of the way.
    std::vector<bool> is_tunnel;
    for (const KeyframeLocalizability& one : result_) is_tunnel.push_back(one.is_tunnel);
    ExpectedDrive second(map_, stretch, options_.vehicle, std::move(is_tunnel), seed);
    if (absl::Status status = second.Run(learned_); !status.ok()) return status;
    for (std::size_t i = 0; i < second.sums().size(); ++i) {
      Tell(second.sums()[i], options_.min_observed_share, result_[stretch.begin + i]);
    }
    return absl::OkStatus();
  }

  /// Most of the work.
  absl::Status FindLikeness(const Stretch& stretch, const std::vector<PlaceView>& views,
                            const LocalizabilityProgress& progress) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      ++looked_at_count_;
      if (!progress(static_cast<double>(looked_at_count_) / static_cast<double>(result_.size()))) {
        return absl::CancelledError("cancelled");
      }
      const PlaceLikeness likeness = aliases_.Find(ViewsFrom(views, i));
      result_[stretch.begin + i].alias = likeness.alias;
      result_[stretch.begin + i].is_tunnel = likeness.is_tunnel;
    }
    return absl::OkStatus();
  }

  const std::shared_ptr<const RadarMap>& map_;
  const LocalizabilityOptions& options_;
  AliasFinder aliases_;
  std::optional<LocalizerSnapshot> learned_;
  std::size_t looked_at_count_ = 0;
  std::vector<KeyframeLocalizability> result_;
};

}  // namespace

ExpectedVehicle LocalizabilityOptions::DefaultVehicle() {
  RadarModel radar;
  radar.id = "front";
  radar.T_vehicle_radar.translation_m = {3.5, 0.0, 0.5};
  ExpectedVehicle vehicle;
  vehicle.rig.radars = {radar};
  return vehicle;
}

std::span<const OptionField<LocalizabilityOptions>> FieldsOf(
    const LocalizabilityOptions& /*options*/) {
  using O = LocalizabilityOptions;
  static constexpr OptionField<O> kFields[] = {
      {"min_observed_share", &O::min_observed_share, 0, 1, "nothing is a tunnel"},
  };
  return kFields;
}

absl::Status Validate(const LocalizabilityOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("vehicle", Validate(options.vehicle)));
  status.Update(Within("aliases", Validate(options.aliases)));
  return status;
}

KeyframeAccuracy AccuracyOf(const KeyframeLocalizability& keyframe) {
  KeyframeAccuracy accuracy{.sigmas = std::nullopt,
                            .is_tunnel = keyframe.is_tunnel,
                            .is_alias = keyframe.alias.has_value()};
  if (keyframe.is_known) {
    accuracy.sigmas = {.along_m = keyframe.along_sigma_m,
                       .across_m = keyframe.across_sigma_m,
                       .heading_rad = keyframe.heading_sigma_rad};
  }
  return accuracy;
}

absl::StatusOr<std::vector<KeyframeLocalizability>> ComputeLocalizability(
    const std::shared_ptr<const RadarMap>& map, const LocalizabilityOptions& options,
    const LocalizabilityProgress& progress) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  return Computation(map, options).Run(progress);
}

}  // namespace dcloc
