#include "client/evaluation/paper/nuscenes_revisits.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/datasets/files/check_range.h"
#include "client/datasets/files/json_table.h"

namespace dcloc::paper {
namespace {

struct Log {
  std::string location;
  std::string vehicle;
};

// What is found by following tokens from table to table.
struct PendingFrame {
  std::size_t track;
  std::size_t index;
};

absl::Status ReadScenes(const std::filesystem::path& tables, std::vector<SceneTrack>& tracks,
                        std::unordered_map<std::string, std::size_t>& track_of_scene) {
  std::unordered_map<std::string, Log> logs;  // only looked up, as all maps here
  absl::Status status = ReadTable(tables / "log.json", [&](TableRecord& record) {
    logs.emplace(record.Text("token"),
                 Log{std::string(record.Text("location")), std::string(record.Text("vehicle"))});
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return ReadTable(tables / "scene.json", [&](TableRecord& record) {
    const auto log = logs.find(std::string(record.Text("log_token")));
    if (log == logs.end()) return absl::DataLossError("\"log_token\" is not in log.json");
    track_of_scene.emplace(record.Text("token"), tracks.size());
    tracks.push_back({.scene = std::string(record.Text("name")),
                      .location = log->second.location,
                      .vehicle = log->second.vehicle});
    return absl::OkStatus();
  });
}

// The key frames without their poses; `pending` tells where the pose of a token goes.
absl::Status ReadFrames(const std::filesystem::path& tables,
                        const std::unordered_map<std::string, std::size_t>& track_of_scene,
                        std::vector<SceneTrack>& tracks,
                        std::unordered_map<std::string, PendingFrame>& pending) {
  std::unordered_map<std::string, std::size_t> track_of_sample;
  absl::Status status = ReadTable(tables / "sample.json", [&](TableRecord& record) {
    const auto track = track_of_scene.find(std::string(record.Text("scene_token")));
    if (track == track_of_scene.end()) {
      return absl::DataLossError("\"scene_token\" is not in scene.json");
    }
    track_of_sample.emplace(record.Text("token"), track->second);
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return ReadTable(tables / "sample_data.json", [&](TableRecord& record) {
    // Key frames lie in samples/, what is between them in sweeps/.
    if (!absl::StartsWith(record.Text("filename"), "samples/RADAR_FRONT/")) return absl::OkStatus();
    const auto track = track_of_sample.find(std::string(record.Text("sample_token")));
    if (track == track_of_sample.end()) {
      return absl::DataLossError("\"sample_token\" is not in sample.json");
    }
    auto& frames = tracks[track->second].key_frames;
    pending.emplace(record.Text("ego_pose_token"), PendingFrame{track->second, frames.size()});
    frames.push_back({.stamp = Stamp(std::chrono::microseconds(record.Integer("timestamp")))});
    return absl::OkStatus();
  });
}

absl::Status ReadPoses(const std::filesystem::path& tables,
                       const std::unordered_map<std::string, PendingFrame>& pending,
                       std::vector<SceneTrack>& tracks) {
  std::size_t found = 0;
  absl::Status status = ReadTable(tables / "ego_pose.json", [&](TableRecord& record) {
    const auto frame = pending.find(std::string(record.Text("token")));
    if (frame == pending.end()) return absl::OkStatus();
    const auto t = record.Numbers<3>("translation");
    const auto q = record.Numbers<4>("rotation");
    tracks[frame->second.track].key_frames[frame->second.index].T_map_vehicle = {
        .translation_m = {t[0], t[1], t[2]}, .rotation = {q[0], q[1], q[2], q[3]}};
    ++found;
    return absl::OkStatus();
  });
  if (!status.ok() || found == pending.size()) return status;
  return absl::DataLossError(absl::StrCat((tables / "ego_pose.json").string(), ": has ", found,
                                          " of the ", pending.size(),
                                          " poses of RADAR_FRONT's key frames"));
}

// The scene of the nearest key frame among the first `track_count` tracks; nullptr for none.
const SceneTrack* NearestTrack(const std::vector<SceneTrack>& tracks, std::size_t track_count,
                               const std::string& location, const KeyFrame& frame,
                               const RevisitOptions& options) {
  const SceneTrack* nearest = nullptr;
  double nearest_m = options.max_distance_m;
  const Pose2 here = Flatten(frame.T_map_vehicle);
  for (std::size_t i = 0; i < track_count; ++i) {
    if (tracks[i].location != location) continue;
    for (const KeyFrame& other : tracks[i].key_frames) {
      const Pose2 there = Flatten(other.T_map_vehicle);
      const double distance_m = (there.translation_m - here.translation_m).norm();
      if (distance_m > nearest_m) continue;
      if (std::abs(WrapAngle(there.yaw_rad - here.yaw_rad)) > options.max_turn_rad) continue;
      nearest = &tracks[i];
      nearest_m = distance_m;
    }
  }
  return nearest;
}

}  // namespace

absl::StatusOr<std::vector<SceneTrack>> ReadSceneTracks(const std::filesystem::path& tables) {
  std::vector<SceneTrack> tracks;
  std::unordered_map<std::string, std::size_t> track_of_scene;
  std::unordered_map<std::string, PendingFrame> pending;
  absl::Status status = ReadScenes(tables, tracks, track_of_scene);
  if (status.ok()) status = ReadFrames(tables, track_of_scene, tracks, pending);
  if (status.ok()) status = ReadPoses(tables, pending, tracks);
  if (!status.ok()) return status;
  std::erase_if(tracks, [](const SceneTrack& track) { return track.key_frames.empty(); });
  for (SceneTrack& track : tracks) {
    std::ranges::sort(track.key_frames, {}, &KeyFrame::stamp);
  }
  std::ranges::sort(tracks, {},
                    [](const SceneTrack& track) { return track.key_frames.front().stamp; });
  return tracks;
}

absl::Status Validate(const RevisitOptions& options) {
  absl::Status status = CheckRange("max_distance_m", options.max_distance_m, 0.01, 1000.0);
  status.Update(CheckRange("max_turn_rad", options.max_turn_rad, 0.0, 3.2));
  status.Update(CheckRange("min_pairs", options.min_pairs, 1, 1000));
  return status;
}

absl::StatusOr<std::vector<Revisit>> FindRevisits(const std::vector<SceneTrack>& tracks,
                                                  const RevisitOptions& options) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  std::vector<Revisit> revisits;
  for (std::size_t live = 0; live < tracks.size(); ++live) {
    const SceneTrack* running = nullptr;  // the map scene of the run of key frames at hand
    int pair_count = 0;
    Revisit revisit;
    const auto end_run = [&] {
      if (pair_count >= options.min_pairs) revisits.push_back(revisit);
      pair_count = 0;
    };
    for (const KeyFrame& frame : tracks[live].key_frames) {
      const SceneTrack* nearest = NearestTrack(tracks, live, tracks[live].location, frame, options);
      if (nearest != running) end_run();
      running = nearest;
      if (nearest == nullptr) continue;
      if (pair_count == 0) revisit = {nearest->scene, tracks[live].scene, frame.stamp, {}};
      revisit.end = frame.stamp;
      ++pair_count;
    }
    end_run();
  }
  return revisits;
}

}  // namespace dcloc::paper
