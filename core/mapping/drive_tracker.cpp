#include "core/mapping/drive_tracker.h"

#include <cmath>
#include <utility>

namespace dcloc {
namespace {

MapReturn ReturnOf(const RadarPoint& point, const Pose2& T_node_vehicle, std::uint32_t scan) {
  const Pose3 T = Embed(T_node_vehicle);
  const Eigen::Matrix3d rotation = T.Rotation();
  const Eigen::Matrix3f c = (rotation * point.covariance_m2 * rotation.transpose()).cast<float>();
  const Eigen::Vector2f slant_per_m =
      (rotation.topLeftCorner<2, 2>() * point.slant_per_m).cast<float>();
  return {.position_m = T * point.position_m,
          .covariance_m2 = {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)},
          .rcs_dbsm = point.rcs_dbsm,
          .scan = scan,
          .slant_per_m = {slant_per_m.x(), slant_per_m.y()}};
}

}  // namespace

std::span<const OptionField<DriveTrackerOptions>> FieldsOf(const DriveTrackerOptions& /*options*/) {
  using O = DriveTrackerOptions;
  static constexpr OptionField<O> kFields[] = {
      {"node_spacing_m", &O::node_spacing_m, 1, 100},
      {"min_move_m", &O::min_move_m, 0, 10, "every scan is taken"},
      {"min_turn_rad", &O::min_turn_rad, 0, 1, "every scan is taken"},
      {"cell_m", &O::cell_m, 0.05, 10},
      {"min_scan_count", &O::min_scan_count, 1, 1000},
  };
  return kFields;
}

absl::Status Validate(const DriveTrackerOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("ego_motion", Validate(options.ego_motion)));
  status.Update(Within("static_points", Validate(options.static_points)));
  return status;
}

DriveTracker::DriveTracker(std::string drive_name, Rig rig, const DriveTrackerOptions& options)
    : rig_(std::move(rig)),
      options_(options),
      ego_motion_(options.ego_motion),
      last_taken_(rig_.radars.size()) {
  track_.name = std::move(drive_name);
  for (const RadarModel& radar : rig_.radars) track_.radars.push_back({.radar_id = radar.id});
}

absl::Status DriveTracker::Add(const Scan& scan) {
  if (absl::Status status = Validate(scan, rig_); !status.ok()) return status;
  const std::size_t radar_index = rig_.IndexOf(scan.radar_id);
  const RadarModel& radar = rig_.radars[radar_index];
  const EgoVelocity& velocity = ego_motion_.Advance(scan, radar);
  const Motion& motion = ego_motion_.since_previous();
  since_part_ = Compose(since_part_, motion);
  track_.arc_length_m += motion.T_from_to.translation_m.head<2>().norm();
  const Pose2 T_odometry_before =
      track_.scans.empty() ? Pose2{} : track_.scans.back().T_odometry_vehicle;
  track_.scans.push_back({scan.stamp, T_odometry_before * Flatten(motion.T_from_to)});

  std::vector<RadarPoint> points = StaticPoints(scan, radar, velocity, options_.static_points);
  RadarTally& tally = track_.radars[radar_index];
  ++tally.scan_count;
  tally.target_count += scan.size();
  tally.static_count += points.size();

  if (track_.arc_length_m - node_begin_m_ >= options_.node_spacing_m && !parts_.empty())
    CloseNode();
  if (ShowsSomethingNew(radar_index)) {
    parts_.push_back(
        {track_.scans.size() - 1, since_part_, track_.arc_length_m, std::move(points)});
    since_part_ = {};
  }
  return absl::OkStatus();
}

bool DriveTracker::ShowsSomethingNew(std::size_t radar_index) {
  const Pose2& now = track_.scans.back().T_odometry_vehicle;
  std::optional<Pose2>& last = last_taken_[radar_index];
  if (last) {
    const Pose2 moved = last->Inverse() * now;
    if (moved.translation_m.norm() < options_.min_move_m &&
        std::abs(WrapAngle(moved.yaw_rad)) < options_.min_turn_rad) {
      return false;
    }
  }
  last = now;
  return true;
}

// The node lies at the middle one of its scans, where the others are least far.
void DriveTracker::CloseNode() {
  const std::size_t middle = parts_.size() / 2;
  const TrackedScan& at = track_.scans[parts_[middle].scan];
  Motion to_node;
  for (std::size_t i = 0; i <= middle; ++i) to_node = Compose(to_node, parts_[i].motion);
  SurveyNode node{.stamp = at.stamp,
                  .T_odometry_node = at.T_odometry_vehicle,
                  .motion = ToEstimate<2>(to_node),
                  .arc_length_m = parts_[middle].arc_length_m,
                  .landmarks = FuseParts(at.T_odometry_vehicle)};
  for (const GaussianPoint<2>& landmark : node.landmarks) node.centre_m += landmark.mean_m;
  if (!node.landmarks.empty()) node.centre_m /= static_cast<double>(node.landmarks.size());
  track_.nodes.push_back(std::move(node));

  Motion since_node;
  for (std::size_t i = middle + 1; i < parts_.size(); ++i) {
    since_node = Compose(since_node, parts_[i].motion);
  }
  since_part_ = Compose(since_node, since_part_);
  node_begin_m_ = track_.arc_length_m;
  parts_.clear();
}

std::vector<GaussianPoint<2>> DriveTracker::FuseParts(const Pose2& T_odometry_node) const {
  std::vector<MapReturn> returns;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Pose2 T_node_vehicle =
        T_odometry_node.Inverse() * track_.scans[parts_[i].scan].T_odometry_vehicle;
    for (const RadarPoint& point : parts_[i].points) {
      returns.push_back(ReturnOf(point, T_node_vehicle, static_cast<std::uint32_t>(i)));
    }
  }
  const std::vector<std::uint32_t> pass_of_scan(parts_.size(), 0);
  const std::vector<Landmark> fused =
      FuseLandmarks(returns, pass_of_scan, rig_.MeasuresElevation(),
                    {.cell_m = options_.cell_m, .min_scan_count = options_.min_scan_count});
  std::vector<GaussianPoint<2>> landmarks;
  landmarks.reserve(fused.size());
  for (const Landmark& landmark : fused) {
    landmarks.push_back({.mean_m = landmark.position_m.head<2>(),
                         .covariance_m2 = landmark.covariance_m2.topLeftCorner<2, 2>()});
  }
  return landmarks;
}

DriveTrack DriveTracker::Finish() {
  if (!parts_.empty()) CloseNode();
  return std::move(track_);
}

}  // namespace dcloc
