#include "client/datasets/bag_presets.h"

#include <algorithm>
#include <array>
#include <optional>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "client/datasets/bag_overview.h"
#include "client/datasets/files/paths_below.h"
#include "client/datasets/rosbag.h"
#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReferenceBag = "gt_odom.bag";

Pose3 Turned(const Eigen::Vector3d& translation_m, double yaw_deg, double pitch_deg) {
  return {translation_m, Eigen::AngleAxisd(yaw_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(pitch_deg * kRadPerDeg, Eigen::Vector3d::UnitY())};
}

/// The radar of a topic of clouds with x, y, z and a range rate, where the bag has it.
void AddRadar(const BagOverview& overview, const char* id, const char* topic, const Pose3& mount,
              BagMapping& mapping) {
  const BagTopic* const found = overview.Find(topic);
  const bool is_taken =
      std::ranges::find(mapping.radars, id, &RadarMapping::id) != mapping.radars.end();
  if (found == nullptr || !found->fault.empty() || is_taken) return;
  const auto rate = std::ranges::find_if(found->fields, [](const std::string& field) {
    return absl::EqualsIgnoreCase(field, "doppler");
  });
  RadarMapping radar{.id = id, .topic = topic, .x = "x", .y = "y", .z = "z"};
  // A cloud without targets may come without channels, too: the name that the drivers write.
  radar.range_rate = rate == found->fields.end() ? "Doppler" : *rate;
  radar.T_vehicle_radar = mount;
  mapping.radars.push_back(std::move(radar));
}

/// The gyroscope, where the bag has it; then it and the radars' Doppler are the vehicle's velocity.
void AddImu(const BagOverview& overview, const char* topic, BagMapping& mapping) {
  if (overview.Find(topic) == nullptr) return;
  mapping.imu_topic = topic;
  mapping.T_vehicle_imu = Pose3();
  mapping.velocity_by_doppler = true;
}

/// The body frame of the set's calibration: x forward, y left, z up, below the lidar. Poses are the
/// lidar's, whose x axis looks to the left.
BagMapping SnailRadar(const BagOverview& overview, const fs::path& root, const fs::path& bag) {
  const fs::path drive = fs::path(bag).replace_extension();
  const fs::path from_root = drive.lexically_relative(root);
  const std::string group = drive.parent_path().filename().string();
  // The ARS548 looks to the right, and up; until the morning of 2023-11-05 more than later.
  const bool is_early = absl::StartsWith(group, "20231104") || group == "20231105";
  const double pitch_deg = is_early ? -5.0 : -1.0;
  BagMapping mapping;
  AddRadar(overview, "ars548", "/ars548", Turned({0.0, 0.0, 0.07}, -3.0, pitch_deg), mapping);
  const Pose3 oculii{{0.07, 0.0, -0.115}, Eigen::Quaterniond::Identity()};
  AddRadar(overview, "oculii", "/radar_pcl2", oculii, mapping);
  AddRadar(overview, "oculii", "/radar_enhanced_pcl2", oculii, mapping);
  AddImu(overview, "/x36d/imu_raw", mapping);
  const std::array<fs::path, 3> candidates = {root / "ref_trajs_all" / from_root, drive,
                                              bag.parent_path()};
  std::error_code error;
  for (const fs::path& folder : candidates) {
    if (!fs::exists(folder / "tls_T_xt32.txt", error)) continue;
    mapping.reference_file =
        (folder / "tls_T_xt32.txt").lexically_proximate(bag.parent_path()).string();
    mapping.T_vehicle_reference = Turned(Eigen::Vector3d::Zero(), 90.0, 0.0);
    break;
  }
  return mapping;
}

/// The frame of the Livox lidar, whose poses and turn rates these are.
BagMapping Ntu4dRadLm(const BagOverview& overview, const fs::path& bag) {
  Eigen::Matrix3d R;
  R << 0.998742, -0.021546, 0.045280, 0.020570, 0.999549, 0.021905, -0.045731, -0.020946, 0.998734;
  const Pose3 mount{{0.2960, -0.1299, -0.0045}, Eigen::Quaterniond(R).normalized()};
  BagMapping mapping;
  mapping.vehicle_frame = "livox_frame";
  AddRadar(overview, "oculii", "/radar_pcl", mount, mapping);
  AddRadar(overview, "oculii", "/radar_enhanced_pcl", mount, mapping);
  AddImu(overview, "/livox/imu", mapping);
  std::error_code error;
  if (fs::exists(bag.parent_path() / "gt_odom.txt", error)) {
    mapping.reference_file = "gt_odom.txt";
    mapping.T_vehicle_reference = Pose3();
  }
  return mapping;
}

/// The radar's own frame, as the set's calibration is relative to a camera.
BagMapping MscRad4r(const BagOverview& overview) {
  BagMapping mapping;
  AddRadar(overview, "oculii", "/oculii_radar/point_cloud", Pose3(), mapping);
  AddImu(overview, "/imu/data", mapping);
  if (overview.Find("/fix") != nullptr) mapping.reference_topic = "/fix";
  return mapping;
}

}  // namespace

std::vector<std::string> BagSetDrives(const fs::path& root) {
  const std::vector<fs::path> bags = PathsBelow(root, [](const fs::path& path) {
    return path.extension() == ".bag" && path.filename() != kReferenceBag;
  });
  std::vector<std::string> names;
  names.reserve(bags.size());
  for (fs::path bag : bags) names.push_back(bag.replace_extension().generic_string());
  std::ranges::sort(names);
  return names;
}

absl::StatusOr<fs::path> FindBagOfSet(const fs::path& root, const std::string& name) {
  const std::vector<std::string> names = BagSetDrives(root);
  const std::string drive(absl::StripSuffix(name, ".bag"));
  if (std::ranges::find(names, drive) != names.end()) return root / (drive + ".bag");
  return absl::NotFoundError(absl::StrCat(root.string(), ": there is no bag \"", name,
                                          "\"; the bags are ",
                                          names.empty() ? "none" : absl::StrJoin(names, ", ")));
}

absl::StatusOr<BagMapping> MappingOfSet(BagSet set, const fs::path& root, const fs::path& bag) {
  return MappingFor(bag, [&](const BagOverview& overview) {
    switch (set) {
      case BagSet::kSnailRadar:
        return SnailRadar(overview, root, bag);
      case BagSet::kNtu4dRadLm:
        return Ntu4dRadLm(overview, bag);
      case BagSet::kMscRad4r:
        return MscRad4r(overview);
    }
    return BagMapping();
  });
}

absl::StatusOr<Drive> ReadBagSetDrive(BagSet set, const fs::path& root,
                                      const DriveRequest& request) {
  const absl::StatusOr<fs::path> bag = FindBagOfSet(root, request.name);
  if (!bag.ok()) return bag.status();
  const absl::StatusOr<BagMapping> mapping = MappingOfSet(set, root, *bag);
  if (!mapping.ok()) return mapping.status();
  return ReadBagAs(std::string(absl::StripSuffix(request.name, ".bag")), *bag, *mapping, request);
}

}  // namespace dcloc
