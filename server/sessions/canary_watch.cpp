#include "server/sessions/canary_watch.h"

#include <memory>
#include <set>
#include <vector>

#include "server/base/status.h"
#include "server/identity/principal.h"
#include "server/sessions/move_sessions.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxVehicles = 10'000;  // of a version; further ones do not count

}  // namespace

void CanaryWatch::Look() {
  const std::vector<std::shared_ptr<SessionInfo>> sessions = registry_.All();
  // Only where vehicles are in several versions there is something to compare.
  std::map<std::string, std::set<std::int64_t>> versions;
  const auto name_of = [](const SessionInfo& info) {
    return ScopedMapName(info.description.caller.principal.tenant, info.description.map_name);
  };
  for (const auto& info : sessions) versions[name_of(*info)].insert(info->map_version);
  for (const auto& info : sessions) {
    const SessionDescription& description = info->description;
    const int state = info->last_state;
    if (state < 0 || description.map_version_asked_for) continue;
    const std::string name = name_of(*info);
    if (versions[name].size() < 2 && !maps_.contains(name)) continue;
    Watched& watched = maps_[name];
    watched.tenant = description.caller.principal.tenant;
    watched.map_name = description.map_name;
    VersionTally& tally = watched.versions[info->map_version];
    if (tally.size() >= kMaxVehicles && !tally.contains(description.vehicle_id)) continue;
    TrackingCount& count = tally[description.vehicle_id];
    ++count.looks;
    if (state == static_cast<int>(LocalizationState::kTracking)) ++count.tracking;
  }
}

void CanaryWatch::Judge() {
  for (auto map = maps_.begin(); map != maps_.end();) {
    auto& [name, watched] = *map;
    bool is_over = IsOver(name, watched);
    if (!is_over) {
      const Trial trial = CompareVersions(watched.versions[watched.canary_version],
                                          watched.versions[watched.active_version], options_);
      is_over = trial.is_canary_worse && Withdraw(name, watched, trial);
    }
    map = is_over ? maps_.erase(map) : std::next(map);
  }
}

/// Whether there is no canary any more. With other versions than before all begins anew.
bool CanaryWatch::IsOver(const std::string& scoped_name, Watched& watched) const {
  const absl::StatusOr<MapRecord> record = store_.catalogue().GetMap(scoped_name);
  if (!record.ok()) return absl::IsNotFound(record.status());  // else away for a moment
  if (record->canary_version == 0) return true;
  if (record->canary_version != watched.canary_version ||
      record->active_version != watched.active_version) {
    if (watched.canary_version != 0) watched.versions.clear();
    watched.canary_version = record->canary_version;
    watched.active_version = record->active_version;
  }
  return false;
}

bool CanaryWatch::Withdraw(const std::string& scoped_name, const Watched& watched,
                           const Trial& trial) {
  const absl::StatusOr<MapRecord> record = store_.SetCanary(scoped_name, 0, 0.0);
  if (!record.ok()) {
    spdlog::error("canary not withdrawn tenant={} map={} version={} reason={}", watched.tenant,
                  watched.map_name, watched.canary_version, Quoted(record.status().message()));
    return false;
  }
  ++withdrawn_count_;
  const int moved =
      MoveSessions(registry_, store_, watched.tenant, watched.map_name, watched.canary_version);
  spdlog::error(
      "canary withdrawn tenant={} map={} version={} active={} tracking={:.3f} "
      "tracking_active={:.3f} "
      "vehicles={} vehicles_active={} sigmas={:.1f} moved={}",
      watched.tenant, watched.map_name, watched.canary_version, watched.active_version,
      trial.canary_share, trial.active_share, trial.canary_vehicles, trial.active_vehicles,
      trial.sigmas, moved);
  return true;
}

}  // namespace dcloc::server
