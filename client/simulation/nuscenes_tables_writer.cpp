#include "client/simulation/nuscenes_tables_writer.h"

#include <algorithm>
#include <cstdlib>
#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/simulation/option_names.h"

namespace dcloc {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kSamplePeriod = 500'000;  // [us]

std::int64_t MicrosecondsOf(Stamp stamp) {
  return std::chrono::duration_cast<std::chrono::microseconds>(stamp.time_since_epoch()).count();
}

std::uint64_t Fnv1a(const std::string& text, std::uint64_t hash) {
  for (const char c : text) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3ULL;
  }
  return hash;
}

// 32 hexadecimal digits, like nuScenes' own.
std::string Token(const std::string& table, const std::string& name) {
  const std::string text = absl::StrCat(table, "/", name);
  return absl::StrFormat("%016x%016x", simulation::MixBits(Fnv1a(text, 0xcbf29ce484222325ULL)),
                         simulation::MixBits(Fnv1a(text, 0x6c62272e07bb0142ULL)));
}

std::string SampleToken(const std::string& pass, std::size_t sample) {
  return Token("sample", absl::StrCat(pass, "/", sample));
}

Json Translation(const Pose3& pose) {
  return {pose.translation_m.x(), pose.translation_m.y(), pose.translation_m.z()};
}

Json Rotation(const Pose3& pose) {
  return {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()};
}

std::string DateOf(Stamp stamp) {
  const std::chrono::year_month_day date(std::chrono::floor<std::chrono::days>(stamp));
  return absl::StrFormat("%04d-%02u-%02u", static_cast<int>(date.year()),
                         static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
}

std::string LogfileOf(Stamp stamp) {
  const std::chrono::hh_mm_ss time(std::chrono::floor<std::chrono::seconds>(
      stamp - std::chrono::floor<std::chrono::days>(stamp)));
  return absl::StrFormat("sim-%s-%02d-%02d-%02d+0000", DateOf(stamp), time.hours().count(),
                         time.minutes().count(), time.seconds().count());
}

// Of each radar the sweep nearest to each sample time: indices into the drive's scans.
void MarkKeyFrames(const Drive& drive, StoredPass& stored) {
  for (std::size_t sample = 0; sample < stored.sample_times.size(); ++sample) {
    std::map<std::string, std::pair<std::int64_t, std::size_t>> nearest;  // by radar
    for (std::size_t i = 0; i < drive.scans.size(); ++i) {
      const Scan& scan = drive.scans[i].scan;
      const std::int64_t distance =
          std::abs(MicrosecondsOf(scan.stamp) - stored.sample_times[sample]);
      const auto [entry, added] = nearest.emplace(scan.radar_id, std::pair(distance, i));
      if (!added) entry->second = std::min(entry->second, std::pair(distance, i));
    }
    for (const auto& [radar, best] : nearest) {
      stored.sweeps[best.second].is_key_frame = true;
      stored.sweeps[best.second].sample = sample;
    }
  }
}

}  // namespace

StoredPass PlanStorage(const SimulatedPass& pass) {
  const std::vector<DriveScan>& scans = pass.drive.scans;
  const std::int64_t begin = MicrosecondsOf(scans.front().scan.stamp);
  const std::int64_t end = MicrosecondsOf(scans.back().scan.stamp);
  StoredPass stored;
  stored.logfile = LogfileOf(scans.front().scan.stamp);
  stored.date = DateOf(scans.front().scan.stamp);
  for (std::int64_t time = begin; time <= end; time += kSamplePeriod) {
    stored.sample_times.push_back(time);
  }
  for (const DriveScan& entry : scans) {
    const std::int64_t after = MicrosecondsOf(entry.scan.stamp) - begin + kSamplePeriod - 1;
    const auto next = static_cast<std::size_t>(after / kSamplePeriod);
    stored.sweeps.push_back({"", false, std::min(next, stored.sample_times.size() - 1)});
  }
  MarkKeyFrames(pass.drive, stored);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const std::string& channel = scans[i].scan.radar_id;
    stored.sweeps[i].filename = absl::StrCat(stored.sweeps[i].is_key_frame ? "samples/" : "sweeps/",
                                             channel, "/", stored.logfile, "__", channel, "__",
                                             MicrosecondsOf(scans[i].scan.stamp), ".pcd");
  }
  return stored;
}

void NuScenesTables::AddPass(const SimulatedPass& pass, const StoredPass& stored) {
  AddLogAndScene(pass, stored);
  AddSensors(pass);
  AddSweeps(pass, stored);
}

void NuScenesTables::AddLogAndScene(const SimulatedPass& pass, const StoredPass& stored) {
  const std::string& name = pass.drive.name;
  const std::string log_token = Token("log", name);
  log_tokens_.push_back(log_token);
  log_.push_back({{"token", log_token},
                  {"logfile", stored.logfile},
                  {"vehicle", pass.vehicle == 0 ? "sim" : absl::StrCat("sim-", pass.vehicle)},
                  {"date_captured", stored.date},
                  {"location", pass.drive.place}});
  const std::size_t count = stored.sample_times.size();
  scene_.push_back({{"token", Token("scene", name)},
                    {"log_token", log_token},
                    {"nbr_samples", count},
                    {"first_sample_token", SampleToken(name, 0)},
                    {"last_sample_token", SampleToken(name, count - 1)},
                    {"name", name},
                    {"description", "Simulated drive with exact truth, radar only"}});
  for (std::size_t i = 0; i < count; ++i) {
    sample_.push_back({{"token", SampleToken(name, i)},
                       {"timestamp", stored.sample_times[i]},
                       {"prev", i > 0 ? SampleToken(name, i - 1) : ""},
                       {"next", i + 1 < count ? SampleToken(name, i + 1) : ""},
                       {"scene_token", Token("scene", name)}});
  }
}

void NuScenesTables::AddSensors(const SimulatedPass& pass) {
  for (const RadarModel& radar : pass.drive.rig.radars) {
    const std::string sensor_token = Token("sensor", radar.id);
    const bool is_new = std::none_of(sensor_.begin(), sensor_.end(), [&](const Json& sensor) {
      return sensor["token"] == sensor_token;
    });
    if (is_new) {
      sensor_.push_back({{"token", sensor_token}, {"channel", radar.id}, {"modality", "radar"}});
    }
    calibrated_sensor_.push_back(
        {{"token", Token("calibrated_sensor", absl::StrCat(pass.drive.name, "/", radar.id))},
         {"sensor_token", sensor_token},
         {"translation", Translation(radar.T_vehicle_radar)},
         {"rotation", Rotation(radar.T_vehicle_radar)},
         {"camera_intrinsic", Json::array()}});
  }
}

void NuScenesTables::AddSweeps(const SimulatedPass& pass, const StoredPass& stored) {
  std::map<std::string, std::size_t> last;  // row of each radar's sweep before, by radar
  for (std::size_t i = 0; i < stored.sweeps.size(); ++i) {
    const DriveScan& entry = pass.drive.scans[i];
    const StoredSweep& sweep = stored.sweeps[i];
    const std::string& channel = entry.scan.radar_id;
    const std::string token = Token("sample_data", sweep.filename);
    const std::int64_t time = MicrosecondsOf(entry.scan.stamp);
    std::string previous;
    if (const auto before = last.find(channel); before != last.end()) {
      sample_data_[before->second]["next"] = token;
      previous = sample_data_[before->second]["token"].get<std::string>();
    }
    last[channel] = sample_data_.size();
    ego_pose_.push_back({{"token", token},
                         {"timestamp", time},
                         {"rotation", Rotation(entry.T_map_vehicle)},
                         {"translation", Translation(entry.T_map_vehicle)}});
    sample_data_.push_back(
        {{"token", token},
         {"sample_token", SampleToken(pass.drive.name, sweep.sample)},
         {"ego_pose_token", token},
         {"calibrated_sensor_token",
          Token("calibrated_sensor", absl::StrCat(pass.drive.name, "/", channel))},
         {"timestamp", time},
         {"fileformat", "pcd"},
         {"is_key_frame", sweep.is_key_frame},
         {"height", 0},
         {"width", 0},
         {"filename", sweep.filename},
         {"prev", previous},
         {"next", ""}});
  }
}

std::string NuScenesTables::map_filename() const {
  return absl::StrCat("maps/", Token("map", "blank"), ".png");
}

std::vector<std::pair<std::string, Json>> NuScenesTables::All() const {
  const Json map = Json::array({{{"category", "semantic_prior"},
                                 {"token", Token("map", "blank")},
                                 {"filename", map_filename()},
                                 {"log_tokens", log_tokens_}}});
  std::vector<std::pair<std::string, Json>> tables = {
      {"scene", scene_},       {"sample", sample_}, {"sample_data", sample_data_},
      {"ego_pose", ego_pose_}, {"sensor", sensor_}, {"calibrated_sensor", calibrated_sensor_},
      {"log", log_},           {"map", map}};
  for (const char* empty :
       {"attribute", "category", "instance", "sample_annotation", "visibility"}) {
    tables.emplace_back(empty, Json::array());
  }
  return tables;
}

Json CanBusPose(const SimulatedPass& pass) {
  Json messages = Json::array();
  for (const VehicleSignal& signal : pass.signals) {
    const Eigen::Vector3d& a = signal.acceleration_mps2;
    messages.push_back({{"accel", {a.x(), a.y(), a.z()}},
                        {"orientation", Rotation(signal.T_map_vehicle)},
                        {"pos", Translation(signal.T_map_vehicle)},
                        {"rotation_rate", {0.0, 0.0, signal.yaw_rate_radps}},
                        {"utime", MicrosecondsOf(signal.stamp)},
                        {"vel", {signal.speed_mps, 0.0, 0.0}}});
  }
  return messages;
}

Json RigDescription(const Rig& rig, const SimulationOptions& options) {
  Json radars = Json::array();
  for (const RadarModel& radar : rig.radars) {
    radars.push_back({{"id", radar.id},
                      {"beta_s", radar.beta_s},
                      {"beta_sigma_s", radar.beta_sigma_s},
                      {"range_bias_sigma_m", radar.range_bias_sigma_m},
                      {"time_offset_sigma_s", radar.time_offset_sigma_s},
                      {"mount_yaw_sigma_rad", radar.mount_yaw_sigma_rad},
                      {"range_sigma_m", radar.range_sigma_m},
                      {"range_rate_sigma_mps", radar.range_rate_sigma_mps},
                      {"azimuth_sigma_rad", radar.azimuth_sigma_rad},
                      {"elevation_sigma_rad", radar.elevation_sigma_rad},
                      {"has_elevation", radar.has_elevation},
                      {"unambiguous_range_rate_mps", radar.unambiguous_range_rate_mps}});
  }
  const Json simulation = {{"world", NameOf(options.world)},
                           {"radar", NameOf(options.radar)},
                           {"noise", NameOf(options.noise)},
                           {"rig_size", options.rig_size},
                           {"seed", options.seed},
                           {"length_m", options.length_m},
                           {"tunnel_m", options.tunnel_m},
                           {"map_speed_mps", options.map_speed_mps},
                           {"live_speeds_mps", options.live_speeds_mps},
                           {"stops", options.stops},
                           {"scan_rate_hz", options.scan_rate_hz},
                           {"range_rate_step_mps", options.range_rate_step_mps},
                           {"parked_change_share", options.parked_change_share},
                           {"clutter_share", options.clutter_share},
                           {"ghost_share", options.ghost_share}};
  return {{"radars", radars}, {"simulation", simulation}};
}

}  // namespace dcloc
