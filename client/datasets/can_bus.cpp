#include "client/datasets/can_bus.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "client/datasets/files/json_table.h"

namespace dcloc {

std::optional<EgoVelocity> VelocityLog::At(Stamp stamp, std::chrono::nanoseconds max_age) const {
  const auto after =
      std::lower_bound(samples_.begin(), samples_.end(), stamp,
                       [](const Sample& sample, Stamp value) { return sample.stamp < value; });
  const bool has_after = after != samples_.end() && after->stamp - stamp <= max_age;
  const bool has_before = after != samples_.begin() && stamp - std::prev(after)->stamp <= max_age;
  if (!has_after && !has_before) return std::nullopt;
  if (!has_before) return EgoVelocity{after->linear_mps, after->angular_radps, std::nullopt};
  const Sample& before = *std::prev(after);
  if (!has_after) return EgoVelocity{before.linear_mps, before.angular_radps, std::nullopt};
  const double weight = static_cast<double>((stamp - before.stamp).count()) /
                        static_cast<double>((after->stamp - before.stamp).count());
  return EgoVelocity{before.linear_mps + weight * (after->linear_mps - before.linear_mps),
                     before.angular_radps + weight * (after->angular_radps - before.angular_radps),
                     std::nullopt};
}

absl::StatusOr<VelocityLog> ReadCanBusPose(const std::filesystem::path& path) {
  std::vector<VelocityLog::Sample> samples;
  const absl::Status status = ReadTable(path, [&](TableRecord& record) {
    const std::array<double, 3> linear = record.Numbers<3>("vel");
    const std::array<double, 3> angular = record.Numbers<3>("rotation_rate");
    const Stamp stamp(record.Time("utime"));
    if (record.status().ok() && !samples.empty() && stamp <= samples.back().stamp) {
      return absl::DataLossError("\"utime\" is not after the record's before it");
    }
    samples.push_back(
        {stamp, {linear[0], linear[1], linear[2]}, {angular[0], angular[1], angular[2]}});
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return VelocityLog(std::move(samples));
}

}  // namespace dcloc
