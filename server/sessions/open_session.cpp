#include "server/sessions/open_session.h"

#include <openssl/rand.h>

#include <array>
#include <utility>

#include "absl/strings/escaping.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

using Clock = std::chrono::steady_clock;

/// 128 random bits in hexadecimal: nothing that can be guessed.
absl::StatusOr<std::string> RandomName() {
  std::array<unsigned char, 16> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    return absl::InternalError("no random bytes for a session");
  }
  return absl::BytesToHexString({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

absl::StatusOr<std::shared_ptr<SessionRecord>> MakeRecord(const v1::OpenSession& open,
                                                          const Caller& caller,
                                                          const MapVersionRecord& map) {
  absl::StatusOr<std::string> session_id = RandomName();
  if (!session_id.ok()) return session_id.status();
  absl::StatusOr<std::string> resume_token = open.resumable() ? RandomName() : std::string();
  if (!resume_token.ok()) return resume_token.status();
  auto record = std::make_shared<SessionRecord>();
  record->description = {.session_id = *std::move(session_id),
                         .resume_token = *std::move(resume_token),
                         .vehicle_id = open.vehicle_id(),
                         .caller = caller,
                         .map_name = open.map_name(),
                         .map_version_asked_for = open.map_version() != 0,
                         .open_time = std::chrono::system_clock::now(),
                         .drops_oldest = open.queue_policy() == v1::QUEUE_POLICY_DROP_OLDEST};
  record->map_version = map.version;
  return record;
}

absl::StatusOr<LoadedMap> AcquireMap(const convert::SessionRequest& request,
                                     const std::string& tenant, const SessionSources& sources) {
  const Clock::time_point begin = Clock::now();
  const std::string map_name = ScopedMapName(tenant, request.map_name);
  absl::StatusOr<LoadedMap> map = request.map_version == 0
                                      ? sources.store.AcquireFor(map_name, request.vehicle_id)
                                      : sources.store.Acquire(map_name, request.map_version);
  if (!map.ok()) return WithPrefix("open.map: ", map.status());
  sources.context.metrics.ObserveMapAcquired(Clock::now() - begin, map->was_in_memory);
  return map;
}

}  // namespace

absl::StatusOr<std::shared_ptr<Session>> OpenSession(const v1::OpenSession& open,
                                                     const Caller& caller,
                                                     const SessionSources& sources) {
  const std::string& tenant = caller.principal.tenant;
  absl::StatusOr<convert::SessionRequest> request = convert::FromProto(open);
  if (!request.ok()) return request.status();
  absl::StatusOr<LoadedMap> map = AcquireMap(*request, tenant, sources);
  if (!map.ok()) return map.status();
  absl::StatusOr<std::optional<InitialPose>> initial_pose =
      convert::InitialPoseFromProto(open, map->map->info().anchor);
  if (!initial_pose.ok()) return initial_pose.status();
  absl::StatusOr<std::shared_ptr<SessionRecord>> record = MakeRecord(open, caller, map->record);
  if (!record.ok()) return record.status();
  absl::StatusOr<std::shared_ptr<Session>> session =
      Session::Create(sources.context, {.record = *std::move(record),
                                        .map = *std::move(map),
                                        .rig = std::move(request->rig),
                                        .options = request->options,
                                        .initial_pose = *std::move(initial_pose)});
  if (!session.ok()) return WithPrefix("open: ", session.status());
  if (auto subscriber = sources.recordings.Take(tenant, open.vehicle_id())) {
    (*session)->Record(std::move(subscriber), open);
  }
  return session;
}

}  // namespace dcloc::server
