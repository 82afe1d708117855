#include "client/datasets/bag_mapping.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <set>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/datasets/files/file_error.h"
#include "client/datasets/files/json_file.h"

namespace dcloc {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

template <typename Struct, typename Value>
using Key = std::pair<const char*, Value Struct::*>;

constexpr std::array<Key<RadarMapping, std::string>, 10> kRadarTexts = {
    {{"id", &RadarMapping::id},
     {"topic", &RadarMapping::topic},
     {"range", &RadarMapping::range},
     {"azimuth", &RadarMapping::azimuth},
     {"elevation", &RadarMapping::elevation},
     {"x", &RadarMapping::x},
     {"y", &RadarMapping::y},
     {"z", &RadarMapping::z},
     {"range_rate", &RadarMapping::range_rate},
     {"rcs", &RadarMapping::rcs}}};

constexpr std::array<Key<RadarMapping, bool>, 4> kRadarFlags = {
    {{"angles_in_degrees", &RadarMapping::angles_in_degrees},
     {"azimuth_is_clockwise", &RadarMapping::azimuth_is_clockwise},
     {"range_rate_is_towards", &RadarMapping::range_rate_is_towards},
     {"range_rate_is_compensated", &RadarMapping::range_rate_is_compensated}}};

constexpr std::array<Key<BagMapping, std::string>, 6> kBagTexts = {
    {{"motion_topic", &BagMapping::motion_topic},
     {"imu_topic", &BagMapping::imu_topic},
     {"reference_topic", &BagMapping::reference_topic},
     {"reference_file", &BagMapping::reference_file},
     {"vehicle_frame", &BagMapping::vehicle_frame},
     {"map_frame", &BagMapping::map_frame}}};

constexpr std::array<Key<BagMapping, bool>, 1> kBagFlags = {
    {{"velocity_by_doppler", &BagMapping::velocity_by_doppler}}};

constexpr std::array<Key<RadarMapping, std::optional<Pose3>>, 1> kRadarMounts = {
    {{"T_vehicle_radar", &RadarMapping::T_vehicle_radar}}};

constexpr std::array<Key<BagMapping, std::optional<Pose3>>, 2> kBagMounts = {
    {{"T_vehicle_reference", &BagMapping::T_vehicle_reference},
     {"T_vehicle_imu", &BagMapping::T_vehicle_imu}}};

/// True when `key` is one of `keys`, whose value is then taken.
template <typename Struct, typename Value, std::size_t N>
absl::StatusOr<bool> TakeKey(const std::array<Key<Struct, Value>, N>& keys, const std::string& key,
                             const json& value, Struct& target) {
  for (const auto& [name, member] : keys) {
    if (key != name) continue;
    const bool fits = std::is_same_v<Value, bool> ? value.is_boolean() : value.is_string();
    if (!fits) {
      return absl::DataLossError(absl::StrCat(
          "\"", key, "\" must be ", std::is_same_v<Value, bool> ? "true or false" : "a text"));
    }
    target.*member = value.get<Value>();
    return true;
  }
  return false;
}

/// A norm no further from 1 is that of a normalized quaternion.
constexpr double kRoundedNorm = 1e-12;

/// x, y, z, then the quaternion w, x, y, z.
absl::StatusOr<Pose3> MountOf(const std::string& key, const json& value) {
  constexpr std::size_t kNumbers = 7;
  const bool are_numbers =
      value.is_array() && value.size() == kNumbers &&
      std::ranges::all_of(value, [](const json& number) { return number.is_number(); });
  if (!are_numbers) {
    return absl::DataLossError(absl::StrCat(
        "\"", key, "\" must be seven numbers: x, y, z [m] and a quaternion w, x, y, z"));
  }
  const auto at = [&](std::size_t i) { return value[i].get<double>(); };
  Pose3 mount{{at(0), at(1), at(2)}, Eigen::Quaterniond(at(3), at(4), at(5), at(6))};
  if (std::abs(mount.rotation.norm() - 1.0) > 0.01) {
    return absl::DataLossError(absl::StrCat("the quaternion of \"", key, "\" has the norm ",
                                            mount.rotation.norm(), "; it must be 1"));
  }
  // What a mapping's file holds is normalized: to do it again could change the last bit.
  if (std::abs(mount.rotation.norm() - 1.0) > kRoundedNorm) mount.rotation.normalize();
  return mount;
}

/// True when `key` is one of the mounts `keys`, which is then taken.
template <typename Struct, std::size_t N>
absl::StatusOr<bool> TakeMount(const std::array<Key<Struct, std::optional<Pose3>>, N>& keys,
                               const std::string& key, const json& value, Struct& target) {
  for (const auto& [name, member] : keys) {
    if (key != name) continue;
    const absl::StatusOr<Pose3> mount = MountOf(key, value);
    if (!mount.ok()) return mount.status();
    target.*member = *mount;
    return true;
  }
  return false;
}

/// Takes a key into one of three kinds of members. DataLoss for a key of none.
template <typename Struct, std::size_t T, std::size_t F, std::size_t M>
absl::Status TakeAny(const std::array<Key<Struct, std::string>, T>& texts,
                     const std::array<Key<Struct, bool>, F>& flags,
                     const std::array<Key<Struct, std::optional<Pose3>>, M>& mounts,
                     const std::string& key, const json& value, Struct& target) {
  absl::StatusOr<bool> taken = TakeKey(texts, key, value, target);
  if (taken.ok() && !*taken) taken = TakeKey(flags, key, value, target);
  if (taken.ok() && !*taken) taken = TakeMount(mounts, key, value, target);
  if (!taken.ok()) return taken.status();
  return *taken ? absl::OkStatus() : absl::DataLossError(absl::StrCat("unknown key \"", key, "\""));
}

absl::StatusOr<RadarMapping> RadarMappingOf(const json& entry) {
  if (!entry.is_object()) return absl::DataLossError("each of \"radars\" must be an object");
  const auto id = entry.find("id");
  const std::string name =
      id != entry.end() && id->is_string() ? id->get<std::string>() : "without id";
  RadarMapping radar;
  for (const auto& [key, value] : entry.items()) {
    const absl::Status status = TakeAny(kRadarTexts, kRadarFlags, kRadarMounts, key, value, radar);
    if (!status.ok()) {
      return absl::DataLossError(absl::StrCat("radar ", name, ": ", status.message()));
    }
  }
  return radar;
}

absl::StatusOr<BagMapping> MappingOf(const json& document) {
  if (!document.is_object() || !document.contains("radars") || !document["radars"].is_array()) {
    return absl::DataLossError("must be an object with an array \"radars\"");
  }
  BagMapping mapping;
  for (const auto& [key, value] : document.items()) {
    if (key == "radars") continue;
    const absl::Status status = TakeAny(kBagTexts, kBagFlags, kBagMounts, key, value, mapping);
    if (!status.ok()) return status;
  }
  for (const json& entry : document["radars"]) {
    absl::StatusOr<RadarMapping> radar = RadarMappingOf(entry);
    if (!radar.ok()) return radar.status();
    mapping.radars.push_back(*std::move(radar));
  }
  return mapping;
}

template <typename Struct, std::size_t N>
void AddMounts(const std::array<Key<Struct, std::optional<Pose3>>, N>& keys, const Struct& source,
               ordered_json& document) {
  for (const auto& [name, member] : keys) {
    const std::optional<Pose3>& mount = source.*member;
    if (!mount) continue;
    const Eigen::Vector3d& t = mount->translation_m;
    const Eigen::Quaterniond& q = mount->rotation;
    document[name] = {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()};
  }
}

absl::Status CheckRadarMapping(const RadarMapping& radar) {
  if (radar.id.empty() || radar.topic.empty()) {
    return absl::InvalidArgumentError("a radar has no id or no topic");
  }
  const bool is_polar = !radar.range.empty() && !radar.azimuth.empty();
  const bool is_cartesian = radar.range.empty() && !radar.x.empty() && !radar.y.empty();
  if (is_polar == is_cartesian) {
    return absl::InvalidArgumentError(
        absl::StrCat("radar ", radar.id, ": name the fields range and azimuth, or x and y"));
  }
  if (radar.range_rate.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("radar ", radar.id, ": range_rate names no field"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Validate(const BagMapping& mapping) {
  if (mapping.radars.empty()) return absl::InvalidArgumentError("there is no radar");
  std::set<std::string> ids;
  std::set<std::string> topics;
  for (const RadarMapping& radar : mapping.radars) {
    if (absl::Status status = CheckRadarMapping(radar); !status.ok()) return status;
    if (!ids.insert(radar.id).second || !topics.insert(radar.topic).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("radar ", radar.id, ": its id or its topic is another radar's too"));
    }
  }
  if (mapping.vehicle_frame.empty()) return absl::InvalidArgumentError("vehicle_frame is empty");
  if (!mapping.reference_topic.empty() && !mapping.reference_file.empty()) {
    return absl::InvalidArgumentError(
        "reference_topic and reference_file are both set; poses are of one of them");
  }
  const bool has_imu = !mapping.imu_topic.empty();
  if (mapping.velocity_by_doppler && (!has_imu || !mapping.motion_topic.empty())) {
    return absl::InvalidArgumentError(
        "velocity_by_doppler needs an imu_topic, and no motion_topic beside it");
  }
  return absl::OkStatus();
}

absl::StatusOr<BagMapping> ReadBagMapping(const std::filesystem::path& path) {
  const absl::StatusOr<json> document = ReadJson(path);
  if (!document.ok()) return document.status();
  absl::StatusOr<BagMapping> mapping = MappingOf(*document);
  absl::Status status = mapping.status();
  if (status.ok()) status = Validate(*mapping);
  if (!status.ok()) return FileError(path, status.message());
  return mapping;
}

ordered_json BagMappingJson(const BagMapping& mapping) {
  ordered_json document;
  for (const auto& [name, member] : kBagTexts) {
    // What mappings of before did not know is written only where it is used.
    if (member != &BagMapping::reference_file || !mapping.reference_file.empty()) {
      document[name] = mapping.*member;
    }
  }
  if (mapping.velocity_by_doppler) document["velocity_by_doppler"] = true;
  AddMounts(kBagMounts, mapping, document);
  document["radars"] = ordered_json::array();
  for (const RadarMapping& radar : mapping.radars) {
    ordered_json entry;
    for (const auto& [name, member] : kRadarTexts) {
      if (!(radar.*member).empty()) entry[name] = radar.*member;
    }
    for (const auto& [name, member] : kRadarFlags) entry[name] = radar.*member;
    AddMounts(kRadarMounts, radar, entry);
    document["radars"].push_back(std::move(entry));
  }
  return document;
}

}  // namespace dcloc
