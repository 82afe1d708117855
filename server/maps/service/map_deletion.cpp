#include "server/maps/service/map_deletion.h"

#include <chrono>
#include <limits>
#include <thread>

#include "absl/strings/str_format.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/identity/principal.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

using Clock = std::chrono::steady_clock;

/// A session moves when its worker comes to it; one that has not by then cannot.
constexpr std::chrono::milliseconds kMoveGrace(500);
/// A client that is told that its session ends may read its answers first.
constexpr std::chrono::seconds kDrainDeadline(3);
constexpr std::chrono::milliseconds kPause(10);

/// Deletes, once nothing is in use any more. `end_all` may be called again and again.
template <typename Delete, typename EndAll>
absl::Status DeleteDrained(const Delete& erase, const EndAll& end_all,
                           Clock::duration grace_before_end) {
  const Clock::time_point begin = Clock::now();
  while (true) {
    absl::Status status = erase();
    const Clock::duration elapsed = Clock::now() - begin;
    if (!absl::IsFailedPrecondition(status) || elapsed > kDrainDeadline) return status;
    if (elapsed >= grace_before_end) end_all();
    std::this_thread::sleep_for(kPause);
  }
}

/// New sessions would come as fast as the old ones go.
absl::Status CheckUnlabelled(MapStore& store, const std::string& scoped_name,
                             const v1::DeleteMapVersionRequest& request) {
  const absl::StatusOr<MapRecord> map = store.catalogue().GetMap(scoped_name);
  if (!map.ok()) return map.status();
  const bool active = request.version() == map->active_version;
  if (!active && request.version() != map->canary_version) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrFormat(
      "version %d of map %s is %s; another one must take its place before its sessions are drained",
      request.version(), Quoted(request.map_name()), active ? "active" : "the canary"));
}

}  // namespace

absl::Status DeleteVersion(MapStore& store, const SessionDrainer& drainer,
                           const std::string& tenant, const v1::DeleteMapVersionRequest& request) {
  const std::string& name = request.map_name();
  const std::int64_t version = request.version();
  absl::Status status = CheckMapName("map_name", name);
  status.Update(
      CheckIntegerBetween("version", version, 1, std::numeric_limits<std::int64_t>::max()));
  if (!status.ok()) return status;
  const std::string scoped_name = ScopedMapName(tenant, name);
  const auto erase = [&] { return store.DeleteVersion(scoped_name, version); };
  if (request.drain_sessions()) {
    status = CheckUnlabelled(store, scoped_name, request);
    if (!status.ok()) return status;
    drainer.move_or_end(tenant, name, version);
    status = DeleteDrained(
        erase, [&] { drainer.end_all(tenant, name, version); }, kMoveGrace);
  } else {
    status = erase();
  }
  if (!status.ok()) return status;
  spdlog::info("map version deleted tenant={} map={} version={}", tenant, name, version);
  return status;
}

absl::Status DeleteMap(MapStore& store, PassStore& passes, const SessionDrainer& drainer,
                       const std::string& tenant, const v1::DeleteMapRequest& request) {
  const std::string& name = request.map_name();
  absl::Status status = CheckMapName("map_name", name);
  if (!status.ok()) return status;
  const auto erase = [&] { return store.DeleteMap(ScopedMapName(tenant, name)); };
  status = request.drain_sessions()
               ? DeleteDrained(
                     erase, [&] { drainer.end_all(tenant, name, 0); }, Clock::duration::zero())
               : erase();
  if (!status.ok()) return status;
  spdlog::info("map deleted tenant={} map={}", tenant, name);
  // Another map of that name has not consented to anything.
  const ConsentRow consent{.subject = ConsentSubject::kMap, .name = name};
  return WithPrefix("the map is deleted, but not its passes: ",
                    passes.WithdrawConsent(tenant, consent).status());
}

}  // namespace dcloc::server
