#include "client/datasets/nuscenes_tables.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "client/datasets/files/file_error.h"
#include "client/datasets/files/json_table.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

// Tokens are only looked up, never iterated over.
using TokenSet = std::unordered_set<std::string>;

struct SceneTokens {
  std::string scene;
  std::string log;
};

struct Mount {
  std::string channel;
  Pose3 T_vehicle_radar;
};
using Mounts = std::unordered_map<std::string, Mount>;  // by calibrated_sensor token

absl::Status Dangling(absl::string_view key, absl::string_view token, absl::string_view table) {
  return absl::DataLossError(absl::StrCat("\"", key, "\" ", token, " is not in ", table, ".json"));
}

absl::StatusOr<Pose3> ReadPose(TableRecord& record) {
  const std::array<double, 3> translation = record.Numbers<3>("translation");
  const std::array<double, 4> rotation = record.Numbers<4>("rotation");
  Pose3 pose;
  pose.translation_m = {translation[0], translation[1], translation[2]};
  pose.rotation = {rotation[0], rotation[1], rotation[2], rotation[3]};
  const double norm = pose.rotation.norm();
  if (record.status().ok() && !(std::abs(norm - 1.0) < 1e-2)) {
    return absl::DataLossError(
        absl::StrCat("\"rotation\" has norm ", norm, "; a unit quaternion is needed"));
  }
  if (record.status().ok()) pose.rotation.normalize();
  return pose;
}

absl::StatusOr<SceneTokens> FindScene(const fs::path& path, const std::string& name) {
  SceneTokens found;
  std::vector<std::string> names;
  const absl::Status status = ReadTable(path, [&](TableRecord& record) {
    names.emplace_back(record.Text("name"));
    if (names.back() == name) {
      found = {std::string(record.Text("token")), std::string(record.Text("log_token"))};
    }
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  if (found.scene.empty()) {
    return absl::NotFoundError(absl::StrCat(path.string(), ": there is no scene \"", name,
                                            "\"; the scenes are ", absl::StrJoin(names, ", ")));
  }
  return found;
}

absl::StatusOr<std::string> ReadLocation(const fs::path& path, const std::string& log_token) {
  std::string location;
  bool found = false;
  const absl::Status status = ReadTable(path, [&](TableRecord& record) {
    if (record.Text("token") == log_token) {
      location = std::string(record.Text("location"));
      found = true;
    }
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  if (!found) return FileError(path, absl::StrCat("has no log ", log_token, " of the scene"));
  return location;
}

// Channels of the radars by sensor token, "" for the sensors of other kinds.
absl::StatusOr<std::unordered_map<std::string, std::string>> ReadChannels(const fs::path& path) {
  std::unordered_map<std::string, std::string> channels;
  const absl::Status status = ReadTable(path, [&](TableRecord& record) {
    const bool is_radar = record.Text("modality") == "radar";
    channels.emplace(record.Text("token"), is_radar ? record.Text("channel") : "");
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return channels;
}

// Mounts of all sensors; those that are no radars have an empty channel.
absl::StatusOr<Mounts> ReadMounts(const fs::path& folder) {
  const auto channels = ReadChannels(folder / "sensor.json");
  if (!channels.ok()) return channels.status();
  Mounts mounts;
  const absl::Status status =
      ReadTable(folder / "calibrated_sensor.json", [&](TableRecord& record) {
        const std::string sensor(record.Text("sensor_token"));
        const auto channel = channels->find(sensor);
        if (channel == channels->end()) return Dangling("sensor_token", sensor, "sensor");
        const auto pose = ReadPose(record);
        if (!pose.ok()) return pose.status();
        mounts.emplace(record.Text("token"), Mount{channel->second, *pose});
        return absl::OkStatus();
      });
  if (!status.ok()) return status;
  return mounts;
}

absl::StatusOr<TokenSet> ReadSamples(const fs::path& path, const std::string& scene_token) {
  TokenSet samples;
  const absl::Status status = ReadTable(path, [&](TableRecord& record) {
    if (record.Text("scene_token") == scene_token) samples.emplace(record.Text("token"));
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  if (samples.empty()) return FileError(path, absl::StrCat("has no sample of scene ", scene_token));
  return samples;
}

// One radar of a scene stays where it is; two mounts for it contradict each other.
absl::Status AddMount(const Mount& mount, NuScenesScene& scene) {
  const auto [known, added] = scene.T_vehicle_radar.emplace(mount.channel, mount.T_vehicle_radar);
  if (added || Log(known->second.Inverse() * mount.T_vehicle_radar).norm() < 1e-9) {
    return absl::OkStatus();
  }
  return absl::DataLossError(
      absl::StrCat(mount.channel, " has two different calibrated sensors in one scene"));
}

// The radar sweeps of the scene without their poses, whose tokens go to `pose_tokens`.
absl::Status ReadSweeps(const fs::path& path, const TokenSet& samples, const Mounts& mounts,
                        NuScenesScene& scene, std::vector<std::string>& pose_tokens) {
  return ReadTable(path, [&](TableRecord& record) {
    if (!samples.contains(std::string(record.Text("sample_token")))) return absl::OkStatus();
    const std::string calibrated_sensor(record.Text("calibrated_sensor_token"));
    const auto mount = mounts.find(calibrated_sensor);
    if (mount == mounts.end()) {
      return Dangling("calibrated_sensor_token", calibrated_sensor, "calibrated_sensor");
    }
    if (mount->second.channel.empty()) return absl::OkStatus();
    const std::chrono::microseconds time = record.Time("timestamp");
    scene.sweeps.push_back(
        {mount->second.channel, std::string(record.Text("filename")), Stamp(time), Pose3{}});
    pose_tokens.emplace_back(record.Text("ego_pose_token"));
    return AddMount(mount->second, scene);
  });
}

absl::Status ReadPoses(const fs::path& path, const std::vector<std::string>& pose_tokens,
                       NuScenesScene& scene) {
  std::unordered_map<std::string, Pose3> poses;
  const TokenSet wanted(pose_tokens.begin(), pose_tokens.end());
  absl::Status status = ReadTable(path, [&](TableRecord& record) {
    std::string token(record.Text("token"));
    if (!wanted.contains(token)) return absl::OkStatus();
    const auto pose = ReadPose(record);
    if (!pose.ok()) return pose.status();
    poses.emplace(std::move(token), *pose);
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  for (std::size_t i = 0; i < pose_tokens.size(); ++i) {
    const auto pose = poses.find(pose_tokens[i]);
    if (pose == poses.end()) {
      return FileError(
          path, absl::StrCat("has no pose ", pose_tokens[i], ", which sample_data.json gives ",
                             scene.sweeps[i].filename));
    }
    scene.sweeps[i].T_map_vehicle = pose->second;
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<NuScenesScene> ReadNuScenesScene(const fs::path& folder, const std::string& name) {
  const auto tokens = FindScene(folder / "scene.json", name);
  if (!tokens.ok()) return tokens.status();
  auto location = ReadLocation(folder / "log.json", tokens->log);
  if (!location.ok()) return location.status();
  const auto mounts = ReadMounts(folder);
  if (!mounts.ok()) return mounts.status();
  const auto samples = ReadSamples(folder / "sample.json", tokens->scene);
  if (!samples.ok()) return samples.status();

  NuScenesScene scene;
  scene.location = *std::move(location);
  std::vector<std::string> pose_tokens;
  absl::Status status =
      ReadSweeps(folder / "sample_data.json", *samples, *mounts, scene, pose_tokens);
  if (status.ok()) status = ReadPoses(folder / "ego_pose.json", pose_tokens, scene);
  if (!status.ok()) return status;
  if (scene.sweeps.empty()) {
    return FileError(folder / "sample_data.json",
                     absl::StrCat("has no radar sweep of scene ", name));
  }
  return scene;
}

absl::StatusOr<std::vector<std::string>> ReadNuScenesSceneNames(const fs::path& folder) {
  std::vector<std::string> names;
  const absl::Status status = ReadTable(folder / "scene.json", [&](TableRecord& record) {
    names.emplace_back(record.Text("name"));
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return names;
}

}  // namespace dcloc
