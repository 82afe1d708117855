#include "client/evaluation/baselines/front_end.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/evaluation/baselines/ego_range_rates.h"

namespace dcloc {

absl::StatusOr<Submap> FrontEnd::Add(const Scan& scan, StageListener* listener) {
  absl::Status status = Validate(scan);
  status.Update(CheckOrder(scan));
  if (!status.ok()) return status;
  const RadarModel& radar = *rig_.Find(scan.radar_id);
  last_stamp_ = last_stamp_of_radar_[scan.radar_id] = scan.stamp;

  if (listener != nullptr) listener->OnStageBegin(Stage::kCompensation);
  const EgoVelocity& ego_velocity = ego_motion_.Advance(scan, radar);
  StaticPointsOptions point_options = options_.static_points;
  point_options.compensate = options_.doppler_compensation;
  point_options.per_point_covariance = options_.per_point_covariance;
  const std::vector<RadarPoint> points =
      ego_range_rates_ ? StaticPoints(WithEgoRangeRates(scan, radar, ego_velocity), radar,
                                      ego_velocity, point_options)
                       : StaticPoints(scan, radar, ego_velocity, point_options);

  if (listener != nullptr) listener->OnStageBegin(Stage::kSubmap);
  window_.Push(scan.stamp, static_cast<int>(&radar - rig_.radars.data()), points, since_previous());
  return window_.Join(options_.per_point_covariance ? DriftCovariance::kAdded
                                                    : DriftCovariance::kLeftOut);
}

bool FrontEnd::RegistrationIsDue(Stamp stamp, const Submap& submap) {
  const auto full =
      static_cast<double>(options_.scans_per_submap) * static_cast<double>(rig_.radars.size());
  const bool is_mature = submap.scan_count >= options_.schedule.start_fraction * full ||
                         submap.span >= options_.schedule.start_span;
  if (!last_registration_ && !is_mature) return false;
  if (last_registration_ && stamp - *last_registration_ < options_.schedule.interval) {
    return false;
  }
  last_registration_ = stamp;
  return true;
}

absl::Status FrontEnd::CheckOrder(const Scan& scan) const {
  if (rig_.Find(scan.radar_id) == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("radar_id '", scan.radar_id, "' is not one of the rig's radars"));
  }
  const auto of_radar = last_stamp_of_radar_.find(scan.radar_id);
  const bool repeats = of_radar != last_stamp_of_radar_.end() && scan.stamp <= of_radar->second;
  if (repeats || (last_stamp_ && scan.stamp < *last_stamp_)) {
    return absl::InvalidArgumentError(
        absl::StrCat("stamp is ", scan.stamp.time_since_epoch().count(), " ns of radar '",
                     scan.radar_id, "'; stamps must not go back, and must rise for each radar"));
  }
  return absl::OkStatus();
}

}  // namespace dcloc
