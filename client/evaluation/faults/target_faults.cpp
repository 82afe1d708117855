#include "client/evaluation/faults/target_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/online_calibration/range_rate_errors.h"

namespace dcloc::faults {
namespace {

constexpr double kGhostReach_m = 80.0;
constexpr double kGhostSpeed_mps = 25.0;
constexpr double kMinRange_m = 0.2;

bool IsOf(const StreamScan& entry, const std::optional<std::string>& radar_id) {
  return !radar_id || entry.scan.radar_id == *radar_id;
}

template <typename Change>
void ChangeScansOf(Stream& stream, const Window& window, const std::optional<std::string>& radar_id,
                   const Change& change) {
  for (StreamScan& entry : stream.scans) {
    if (window.Contains(entry.measured) && IsOf(entry, radar_id)) change(entry.scan);
  }
}

void KeepRows(std::vector<float>& column, const std::vector<std::size_t>& rows) {
  if (column.empty()) return;
  std::vector<float> kept;
  kept.reserve(rows.size());
  for (const std::size_t row : rows) kept.push_back(column[row]);
  column = std::move(kept);
}

std::array<std::vector<float>*, 9> Columns(Scan& scan) {
  return {&scan.range_m,
          &scan.range_rate_mps,
          &scan.azimuth_rad,
          &scan.elevation_rad,
          &scan.rcs_dbsm,
          &scan.range_sigma_m,
          &scan.range_rate_sigma_mps,
          &scan.azimuth_sigma_rad,
          &scan.elevation_sigma_rad};
}

void KeepRows(Scan& scan, const std::vector<std::size_t>& rows) {
  for (std::vector<float>* column : Columns(scan)) KeepRows(*column, rows);
}

enum class Whose { kOneRadar, kAllRadars };

using Change = std::function<void(Stream&, const Window&,
                                  const std::optional<std::string>& radar_id, std::uint64_t seed)>;

Fault MakeTargetFault(const std::string& id, std::string label, std::optional<double> duration_s,
                      Whose whose, Change change) {
  return {.id = absl::StrCat("targets-", id),
          .family = "targets",
          .label = std::move(label),
          .duration_s = duration_s,
          .apply = [change = std::move(change), whose](Stream& stream, const Window& window,
                                                       std::uint64_t seed) {
            std::optional<std::string> radar_id;
            if (whose == Whose::kOneRadar) radar_id = stream.rig.radars.front().id;
            change(stream, window, radar_id, seed);
          }};
}

}  // namespace

void FreezeTargets(Stream& stream, const Window& window,
                   const std::optional<std::string>& radar_id) {
  std::map<std::string, Scan> last;
  for (StreamScan& entry : stream.scans) {
    if (!IsOf(entry, radar_id)) continue;
    if (entry.measured < window.begin) last[entry.scan.radar_id] = entry.scan;
    const auto seen = last.find(entry.scan.radar_id);
    if (!window.Contains(entry.measured) || seen == last.end()) continue;
    Scan frozen = seen->second;
    frozen.stamp = entry.scan.stamp;
    frozen.ego_velocity = entry.scan.ego_velocity;
    frozen.ticks = std::move(entry.scan.ticks);
    entry.scan = std::move(frozen);
  }
}

void ZeroRangeRates(Stream& stream, const Window& window,
                    const std::optional<std::string>& radar_id) {
  ChangeScansOf(stream, window, radar_id,
                [](Scan& scan) { std::ranges::fill(scan.range_rate_mps, 0.0F); });
}

void CompensateRangeRates(Stream& stream, const Window& window) {
  for (StreamScan& entry : stream.scans) {
    if (!window.Contains(entry.measured) || !entry.scan.ego_velocity) continue;
    EgoVelocity back = *entry.scan.ego_velocity;
    back.linear_mps *= -1.0;
    back.angular_radps *= -1.0;
    AddEgoMotion(*stream.rig.Find(entry.scan.radar_id), back, entry.scan);
  }
}

void ReplaceByGhosts(Stream& stream, const Window& window,
                     const std::optional<std::string>& radar_id, double share, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto draw = [&](double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
  };
  ChangeScansOf(stream, window, radar_id, [&](Scan& scan) {
    if (scan.size() == 0) return;
    const auto [low, high] = std::ranges::minmax(scan.azimuth_rad);
    for (std::size_t row = 0; row < scan.size(); ++row) {
      if (!std::bernoulli_distribution(share)(random)) continue;
      scan.azimuth_rad[row] = draw(static_cast<double>(low), static_cast<double>(high));
      scan.range_m[row] = draw(kMinRange_m, kGhostReach_m);
      scan.range_rate_mps[row] = draw(-kGhostSpeed_mps, kGhostSpeed_mps);
    }
  });
}

void BiasRange(Stream& stream, const Window& window, const std::optional<std::string>& radar_id,
               double bias_m) {
  ChangeScansOf(stream, window, radar_id, [&](Scan& scan) {
    for (float& range_m : scan.range_m) {
      range_m = static_cast<float>(std::max(kMinRange_m, static_cast<double>(range_m) + bias_m));
    }
  });
}

void AddOwnBody(Stream& stream, const Window& window, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> range_m(1.0F, 15.0F);
  std::normal_distribution<float> range_rate_mps(0.0F, 0.05F);
  ChangeScansOf(stream, window, std::nullopt, [&](Scan& scan) {
    const std::size_t count = scan.size();
    for (std::vector<float>* column : Columns(scan)) {
      if (!column->empty()) column->resize(2 * count);
      if (!column->empty())
        std::copy_n(column->begin(), count, column->begin() + std::ptrdiff_t(count));
    }
    for (std::size_t row = count; row < 2 * count; ++row) {
      scan.range_m[row] = range_m(random);
      scan.range_rate_mps[row] = range_rate_mps(random);
    }
  });
}

void BlockView(Stream& stream, const Window& window, const std::optional<std::string>& radar_id,
               double reach_m) {
  ChangeScansOf(stream, window, radar_id, [&](Scan& scan) {
    std::vector<std::size_t> seen;
    for (std::size_t row = 0; row < scan.size(); ++row) {
      if (static_cast<double>(scan.range_m[row]) <= reach_m) seen.push_back(row);
    }
    KeepRows(scan, seen);
  });
}

std::vector<Fault> TargetFaults() {
  using RadarId = std::optional<std::string>;
  std::vector<Fault> faults;
  const Change freeze = [](Stream& stream, const Window& window, const RadarId& radar_id,
                           std::uint64_t) { FreezeTargets(stream, window, radar_id); };
  const Change zero = [](Stream& stream, const Window& window, const RadarId& radar_id,
                         std::uint64_t) { ZeroRangeRates(stream, window, radar_id); };
  const Change compensate = [](Stream& stream, const Window& window, const RadarId&,
                               std::uint64_t) { CompensateRangeRates(stream, window); };
  const Change ghosts = [](Stream& stream, const Window& window, const RadarId& radar_id,
                           std::uint64_t seed) {
    ReplaceByGhosts(stream, window, radar_id, 0.8, seed);
  };
  const Change bias = [](Stream& stream, const Window& window, const RadarId& radar_id,
                         std::uint64_t) { BiasRange(stream, window, radar_id, 1.0); };
  const Change own_body = [](Stream& stream, const Window& window, const RadarId&,
                             std::uint64_t seed) { AddOwnBody(stream, window, seed); };
  const Change block = [](Stream& stream, const Window& window, const RadarId& radar_id,
                          std::uint64_t) { BlockView(stream, window, radar_id, 8.0); };
  faults.push_back(MakeTargetFault("frozen-10s", "one radar repeats its last scan for 10 s", 10.0,
                                   Whose::kOneRadar, freeze));
  faults.push_back(MakeTargetFault("all-frozen-10s", "all radars repeat their last scan for 10 s",
                                   10.0, Whose::kAllRadars, freeze));
  faults.push_back(MakeTargetFault("rates-zero-10s", "one radar's range rates 0 for 10 s", 10.0,
                                   Whose::kOneRadar, zero));
  faults.push_back(MakeTargetFault("all-rates-zero-10s", "all range rates 0 for 10 s", 10.0,
                                   Whose::kAllRadars, zero));
  faults.push_back(MakeTargetFault("compensated", "range rates compensated by the ego-motion",
                                   std::nullopt, Whose::kAllRadars, compensate));
  faults.back().begin_s = 0.0;
  faults.push_back(MakeTargetFault("ghosts-10s", "80 % of all targets ghosts for 10 s", 10.0,
                                   Whose::kAllRadars, ghosts));
  faults.push_back(MakeTargetFault("range-1m", "one radar's ranges 1 m long", std::nullopt,
                                   Whose::kOneRadar, bias));
  faults.push_back(MakeTargetFault("own-body", "half of all targets move along with the vehicle",
                                   std::nullopt, Whose::kAllRadars, own_body));
  faults.back().begin_s = 0.0;
  faults.push_back(MakeTargetFault("blocked-10s", "all radars see 8 m far for 10 s", 10.0,
                                   Whose::kAllRadars, block));
  return faults;
}

}  // namespace dcloc::faults
