#include "core/passes/placed_pass.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <utility>

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

/// Where in the drive and in the map the scans lie that count.
std::string WhereGood(const PlacedPass& pass) {
  const PlacedScan* first = nullptr;
  const PlacedScan* last = nullptr;
  for (const PlacedScan& scan : pass.scans) {
    if (!IsChosen(scan, ScanChoice::kTracked)) continue;
    if (first == nullptr) first = &scan;
    last = &scan;
  }
  if (first == nullptr) return "";
  const auto second = [&](const PlacedScan& scan) {
    return std::chrono::duration<double>(scan.stamp - pass.scans.front().stamp).count();
  };
  const Eigen::Vector3d& from_m = first->T_map_vehicle.translation_m;
  const Eigen::Vector3d& to_m = last->T_map_vehicle.translation_m;
  return absl::StrFormat(", those from %.1f to %.1f s of it, from (%.0f, %.0f) to (%.0f, %.0f) m",
                         second(*first), second(*last), from_m.x(), from_m.y(), to_m.x(), to_m.y());
}

constexpr double kMinLength_m = 20.0;
constexpr double kMinGoodShare = 0.1;
constexpr double kMaxRefusedShare = 0.2;

}  // namespace

bool IsChosen(const PlacedScan& scan, ScanChoice choice) {
  if (!scan.is_good || choice == ScanChoice::kAll) return scan.is_good;
  return scan.is_beyond_map == (choice == ScanChoice::kBeyondMap);
}

std::size_t PlacedPass::GoodCount() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      scans, [](const PlacedScan& scan) { return IsChosen(scan, ScanChoice::kTracked); }));
}

std::size_t PlacedPass::BeyondCount() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      scans, [](const PlacedScan& scan) { return IsChosen(scan, ScanChoice::kBeyondMap); }));
}

std::string FaultOf(const PlacedPass& pass) {
  const std::size_t good_count = pass.GoodCount();
  const auto scan_count = static_cast<double>(pass.scans.size() + pass.refused_count);
  if (static_cast<double>(pass.refused_count) > kMaxRefusedShare * scan_count) {
    return absl::StrFormat("%d of %.0f scans were refused: %s", pass.refused_count, scan_count,
                           pass.first_refusal);
  }
  if (pass.length_m < kMinLength_m) {
    return absl::StrFormat("it moved %.1f m; %.0f m are the least", pass.length_m, kMinLength_m);
  }
  if (static_cast<double>(good_count) >= kMinGoodShare * scan_count) return "";
  if (pass.unsound_count > pass.untracked_count && pass.unsound_count > pass.unsure_count) {
    return absl::StrFormat("%d of %.0f scans count%s: a source was set aside (%s); check its rig",
                           good_count, scan_count, WhereGood(pass), NameOf(pass.fault));
  }
  if (pass.unsure_count > pass.untracked_count) {
    return absl::StrFormat(
        "%d of %.0f scans count%s: elsewhere the way is not observed, as in a "
        "tunnel",
        good_count, scan_count, WhereGood(pass));
  }
  return absl::StrFormat(
      "%d of %.0f scans count%s: otherwise it is not tracked in the map; it lies elsewhere, or its "
      "rig is wrong",
      good_count, scan_count, WhereGood(pass));
}

absl::StatusOr<PassPlacer> PassPlacer::Create(std::shared_ptr<const RadarMap> map, std::string name,
                                              std::string vehicle, Rig rig,
                                              const PassPlacerOptions& options) {
  auto localizer = Localizer::Create(map, rig, std::nullopt, options.localizer);
  if (!localizer.ok()) {
    return absl::Status(localizer.status().code(),
                        name + ": " + std::string(localizer.status().message()));
  }
  PlacedPass pass;
  pass.name = std::move(name);
  pass.vehicle = std::move(vehicle);
  pass.rig = std::move(rig);
  return PassPlacer(std::move(map), *std::move(localizer), std::move(pass), options);
}

PassPlacer::PassPlacer(std::shared_ptr<const RadarMap> map, Localizer localizer, PlacedPass pass,
                       const PassPlacerOptions& options)
    : options_(options),
      map_(std::move(map)),
      localizer_(std::move(localizer)),
      rig_(std::make_unique<Rig>(pass.rig)),
      judge_(options.worth),
      pass_(std::move(pass)) {}

void PassPlacer::Add(const Scan& scan) {
  const absl::StatusOr<Localization> answer = localizer_.Localize(scan);
  if (!answer.ok()) {
    if (pass_.refused_count++ == 0) pass_.first_refusal = std::string(answer.status().message());
    return;
  }
  if (!pass_.scans.empty() && scan.stamp < pass_.scans.back().stamp) return;  // late
  const RadarModel& radar = *rig_->Find(scan.radar_id);
  const EgoVelocity& velocity = ego_motion_.Advance(scan, radar);
  T_start_vehicle_ = T_start_vehicle_ * ego_motion_.since_previous().T_from_to;
  pass_.length_m += ego_motion_.since_previous().T_from_to.translation_m.norm();
  PlacedScan placed{.stamp = scan.stamp,
                    .radar = rig_->IndexOf(scan.radar_id),
                    .T_map_vehicle = answer->T_map_vehicle,
                    .T_start_vehicle = Flatten(T_start_vehicle_),
                    .sigma_m = HorizontalSigma_m(answer->covariance),
                    .inlier_count = answer->quality.inlier_count,
                    .is_good = false,
                    .points = {}};
  const ScanWorth worth = judge_.Judge(*answer, placed.radar, scan.stamp);
  pass_.fault = judge_.fault();
  pass_.untracked_count += worth == ScanWorth::kUntracked ? 1 : 0;
  pass_.unsound_count += worth == ScanWorth::kUnsound ? 1 : 0;
  pass_.unsure_count += worth == ScanWorth::kUnsure ? 1 : 0;
  placed.is_good = worth == ScanWorth::kGood;
  if (worth != ScanWorth::kUnsound) {  // may count: here, or beyond the map
    // Where the localizer has put them: a map whose radars were corrected has it correct these.
    RadarModel restamped = radar;
    restamped.time_offset_s = localizer_.rig().radars[placed.radar].time_offset_s;
    placed.points = StaticPoints(scan, restamped, velocity, options_.localizer.static_points);
  }
  pass_.scans.push_back(std::move(placed));
}

PlacedPass PassPlacer::Finish() && {
  PlaceBeyondMap(*map_, options_.beyond_map, pass_);
  return std::move(pass_);
}

Stamp FirstGoodStamp(const PlacedPass& pass) {
  return std::ranges::find(pass.scans, true, &PlacedScan::is_good)->stamp;
}

Witness WitnessOf(const PlacedPass& pass) {
  const auto since = FirstGoodStamp(pass).time_since_epoch();
  return {pass.vehicle, std::chrono::duration_cast<std::chrono::days>(since).count()};
}

std::vector<std::size_t> FirstOfWitness(std::span<const PlacedPass> passes) {
  std::map<Witness, std::size_t> firsts;
  std::vector<std::size_t> first_of;
  for (std::size_t p = 0; p < passes.size(); ++p) {
    first_of.push_back(firsts.try_emplace(WitnessOf(passes[p]), p).first->second);
  }
  return first_of;
}

}  // namespace dcloc
