#include "client/datasets/rosbag.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/datasets/bag_contents.h"
#include "client/datasets/bag_motion.h"
#include "client/datasets/bag_overview.h"
#include "client/datasets/file_error.h"
#include "client/datasets/finish_drive.h"
#include "client/datasets/radar_selection.h"
#include "client/datasets/rig_file.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

absl::Status Naming(const fs::path& path, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(path.string(), ": ", status.message()));
}

absl::StatusOr<Rig> RigOf(const BagContents& contents, const BagMapping& mapping) {
  Rig rig;
  for (const RadarMapping& radar : mapping.radars) {
    absl::StatusOr<RadarModel> model = RadarOf(radar, contents, mapping.vehicle_frame);
    if (!model.ok()) return model.status();
    rig.radars.push_back(*std::move(model));
  }
  return rig;
}

double SecondsOf(Stamp stamp) {
  return std::chrono::duration<double>(stamp.time_since_epoch()).count();
}

/// Of scans of which none has a velocity, though the bag has velocities.
absl::Status OtherClock(const BagContents& contents, const BagMapping& mapping) {
  const auto [first, last] = std::ranges::minmax_element(contents.scans, {}, &Scan::stamp);
  return absl::InvalidArgumentError(absl::StrFormat(
      "no message of topic %s is within 0.1 s of any radar scan: its stamps are %.3f s to %.3f s, "
      "those of the radars %.3f s to %.3f s. Are they of one clock?",
      mapping.motion_topic, SecondsOf(contents.motions.front().header.stamp),
      SecondsOf(contents.motions.back().header.stamp), SecondsOf(first->stamp),
      SecondsOf(last->stamp)));
}

/// Adds the scans of the rig's radars that have a pose, or all where there are no poses.
absl::Status AddScans(BagContents& contents, const BagMapping& mapping, const BagMotion& motion,
                      Drive& drive) {
  std::size_t without_pose = 0;
  std::size_t with_velocity = 0;
  for (Scan& scan : contents.scans) {
    const auto radar = std::ranges::find(mapping.radars, scan.radar_id, &RadarMapping::id);
    const RadarModel* const model = drive.rig.Find(scan.radar_id);
    if (model == nullptr) continue;
    scan.ego_velocity = motion.VelocityAt(scan.stamp);
    with_velocity += scan.ego_velocity ? 1U : 0U;
    const std::optional<Pose3> pose = motion.PoseAt(scan.stamp);
    if (!pose && drive.pose_source != PoseSource::kNone) {
      ++without_pose;
      continue;
    }
    if (radar->range_rate_is_compensated) {
      if (absl::Status status = Uncompensate(*model, scan); !status.ok()) return status;
    }
    drive.scans.push_back({std::move(scan), pose.value_or(Pose3())});
  }
  if (with_velocity == 0 && !contents.motions.empty()) return OtherClock(contents, mapping);
  if (without_pose > 0) {
    drive.notes.push_back(
        absl::StrCat(without_pose, " scans are left out, as there is no pose at their stamps"));
  }
  if (drive.scans.empty()) return absl::InvalidArgumentError("no scan has a pose");
  return absl::OkStatus();
}

void Note(const rosbag::BagSummary& summary, Drive& drive) {
  if (summary.is_cut()) {
    drive.notes.push_back(
        absl::StrCat("the bag is cut off at byte ", summary.cut_at, "; what lies before is read"));
  } else if (!summary.has_index) {
    drive.notes.emplace_back(
        "the bag has no index, as if its recording was not ended; all of it is read");
  }
  if (drive.pose_source == PoseSource::kOdometry) {
    drive.notes.emplace_back(
        "its poses are the vehicle's own odometry, which drifts: a map made of it drifts too");
  }
}

absl::StatusOr<Drive> DriveOf(const fs::path& bag, const BagMapping& mapping,
                              const DriveRequest& request) {
  absl::StatusOr<BagContents> contents = ReadBagContents(bag, mapping);
  if (!contents.ok()) return contents.status();
  absl::StatusOr<Rig> rig = RigOf(*contents, mapping);
  if (!rig.ok()) return Naming(bag, rig.status());
  const absl::StatusOr<BagMotion> motion = BagMotion::Create(*contents, mapping);
  if (!motion.ok()) return Naming(bag, motion.status());
  Drive drive{.name = bag.stem().string(), .place = "", .rig = *std::move(rig)};
  drive.pose_source = motion->pose_source();
  Note(contents->summary, drive);
  std::erase_if(drive.rig.radars,
                [&](const RadarModel& radar) { return !IsWanted(request.radars, radar.id); });
  std::error_code error;
  const fs::path rig_file = bag.parent_path() / kRigFileName;
  if (fs::exists(rig_file, error)) {
    if (absl::Status status = ApplyRigFile(rig_file, drive.rig); !status.ok()) return status;
  }
  absl::Status status = AddScans(*contents, mapping, *motion, drive);
  if (status.ok()) status = FinishDrive(request, drive);
  if (!status.ok()) return Naming(bag, status);
  return drive;
}

}  // namespace

absl::StatusOr<RadarModel> RadarOf(const RadarMapping& radar, const BagContents& contents,
                                   const std::string& vehicle_frame) {
  const auto frame = contents.frames.find(radar.id);
  std::optional<Pose3> mount = radar.T_vehicle_radar;
  if (!mount && frame == contents.frames.end()) {
    return absl::NotFoundError(
        absl::StrCat("radar ", radar.id, ": no message of topic ", radar.topic, " has come"));
  }
  if (!mount) mount = contents.transforms.Static(vehicle_frame, frame->second);
  if (!mount) {
    return absl::InvalidArgumentError(absl::StrCat(
        "radar ", radar.id, ": /tf_static does not say where its frame \"", frame->second,
        "\" sits on \"", vehicle_frame, "\"; say it by T_vehicle_radar in ", kBagMappingFileName));
  }
  RadarModel model;
  model.id = radar.id;
  model.T_vehicle_radar = *mount;
  model.has_elevation = radar.HasElevation();
  return model;
}

absl::Status Uncompensate(const RadarModel& radar, Scan& scan) {
  if (!scan.ego_velocity) {
    return absl::InvalidArgumentError(absl::StrCat(
        "radar ", radar.id, ": its range rates are compensated, and at ",
        scan.stamp.time_since_epoch().count(),
        " ns there is no velocity of the vehicle by which they could be what was measured"));
  }
  const Eigen::Vector3d v_vehicle =
      scan.ego_velocity->linear_mps +
      scan.ego_velocity->angular_radps.cross(radar.T_vehicle_radar.translation_m);
  const Eigen::Vector3d v_radar = radar.T_vehicle_radar.Rotation().transpose() * v_vehicle;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double azimuth = scan.azimuth_rad[i];
    const double elevation = scan.elevation_rad.empty() ? 0.0F : scan.elevation_rad[i];
    const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                    std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    scan.range_rate_mps[i] -= static_cast<float>(v_radar.dot(direction));
  }
  return absl::OkStatus();
}

std::vector<std::string> BagNames(const fs::path& root) {
  std::error_code error;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(root, error)) {
    if (entry.path().extension() == ".bag") names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

absl::StatusOr<fs::path> FindBag(const fs::path& root, const std::string& name) {
  std::error_code error;
  const fs::path path = root / (absl::EndsWith(name, ".bag") ? name : name + ".bag");
  if (fs::exists(path, error)) return path;
  const std::vector<std::string> names = BagNames(root);
  return absl::NotFoundError(absl::StrCat(root.string(), ": there is no bag \"", name,
                                          "\"; the bags are ",
                                          names.empty() ? "none" : absl::StrJoin(names, ", ")));
}

absl::StatusOr<BagMapping> MappingFor(const fs::path& bag) {
  std::error_code error;
  const fs::path file = bag.parent_path() / kBagMappingFileName;
  if (fs::exists(file, error)) return ReadBagMapping(file);
  const absl::StatusOr<BagOverview> overview = ReadBagOverview(bag);
  if (!overview.ok()) return overview.status();
  BagMapping mapping = ProposeMapping(*overview);
  if (!mapping.radars.empty()) return mapping;
  if (overview->summary.message_count == 0) {
    const std::int64_t cut_at = overview->summary.cut_at;
    return absl::InvalidArgumentError(absl::StrCat(
        bag.string(), ": has no message",
        cut_at < 0 ? "" : absl::StrCat(" before byte ", cut_at, ", where it is cut off")));
  }
  return absl::InvalidArgumentError(
      absl::StrCat(bag.string(),
                   ": no topic is a point cloud with range rates under a known name; name them in ",
                   kBagMappingFileName, " beside the bag"));
}

absl::StatusOr<Drive> ReadRosbagDrive(const fs::path& root, const DriveRequest& request) {
  const absl::StatusOr<fs::path> bag = FindBag(root, request.name);
  if (!bag.ok()) return bag.status();
  const absl::StatusOr<BagMapping> mapping = MappingFor(*bag);
  if (!mapping.ok()) return mapping.status();
  std::vector<std::string> ids;
  for (const RadarMapping& radar : mapping->radars) ids.push_back(radar.id);
  if (absl::Status status = CheckRadars(request.radars, ids); !status.ok()) return status;
  return DriveOf(*bag, *mapping, request);
}

}  // namespace dcloc
