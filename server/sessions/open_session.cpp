#include "server/sessions/open_session.h"

#include <algorithm>
#include <utility>

#include "server/base/random_name.h"
#include "server/base/status.h"
#include "server/sessions/session_log.h"

namespace dcloc::server {
namespace {

using Clock = std::chrono::steady_clock;

/// Servers may die one after the other before the next has made a ticket; but not so many.
constexpr std::int64_t kMaxEpochsBehind = 16;

absl::StatusOr<std::shared_ptr<SessionInfo>> MakeInfo(const v1::OpenSession& open,
                                                      const Caller& caller,
                                                      const MapVersionRecord& map,
                                                      std::int64_t epoch) {
  absl::StatusOr<std::string> session_id = RandomName(128, "a session");
  if (!session_id.ok()) return session_id.status();
  absl::StatusOr<std::string> resume_token =
      open.resumable() ? RandomName(128, "a session") : std::string();
  if (!resume_token.ok()) return resume_token.status();
  auto info = std::make_shared<SessionInfo>();
  info->description = {.session_id = *std::move(session_id),
                       .resume_token = *std::move(resume_token),
                       .vehicle_id = open.vehicle_id(),
                       .rig = open.rig(),
                       .caller = caller,
                       .map_name = open.map_name(),
                       .map_version_asked_for = open.map_version() != 0,
                       .open_time = std::chrono::system_clock::now(),
                       .drops_oldest = open.queue_policy() == v1::QUEUE_POLICY_DROP_OLDEST,
                       .epoch = epoch};
  info->map_version = map.version;
  return info;
}

/// Opens the ticket of `open`, if it has one.
OpenedTicket OpenTicket(const v1::OpenSession& open, const TicketBinding& binding,
                        const SessionContext& context) {
  if (open.ticket().empty()) return {};
  if (context.tickets == nullptr) {
    return {.use = TicketUse::kNotOffered, .content = {}, .key_id = ""};
  }
  OpenedTicket ticket =
      context.tickets->Open(open.ticket(), binding, std::chrono::system_clock::now());
  if (ticket.use != TicketUse::kAccepted) return ticket;
  const std::int64_t version = open.map_version();
  if (version != 0 && version != ticket.content.map_version) {
    ticket.use = TicketUse::kOtherMapVersion;
  } else if (ticket.content.epoch < open.epoch() - kMaxEpochsBehind) {
    ticket.use = TicketUse::kStale;
  }
  return ticket;
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

/// The version that the ticket is of; or the one that is asked for, where that cannot be had.
absl::StatusOr<LoadedMap> AcquireMapOf(OpenedTicket& ticket, const convert::SessionRequest& request,
                                       const std::string& tenant, const SessionSources& sources) {
  if (ticket.use != TicketUse::kAccepted) return AcquireMap(request, tenant, sources);
  convert::SessionRequest of_ticket = request;
  of_ticket.map_version = ticket.content.map_version;
  absl::StatusOr<LoadedMap> map = AcquireMap(of_ticket, tenant, sources);
  if (map.ok() && map->record.sha256 == ticket.content.map_sha256) return map;
  ticket.use = TicketUse::kOtherMapVersion;
  return AcquireMap(request, tenant, sources);
}

/// Above all that the vehicle has had, as far as it tells; never one that it could not send back.
std::int64_t EpochOf(const convert::SessionRequest& request, const OpenedTicket& ticket) {
  const bool goes_on = ticket.use == TicketUse::kAccepted;
  const std::int64_t highest = std::max(request.epoch, goes_on ? ticket.content.epoch : 0);
  return std::min(highest, convert::kMaxEpoch - 1) + 1;
}

void TellTicketUse(const Session& session, const std::string& key_id, SessionMetrics& metrics) {
  const TicketUse use = session.ticket_use();
  metrics.ObserveTicketUse(use);
  if (use != TicketUse::kNone && use != TicketUse::kAccepted) {
    LogTicketNotTaken(*session.info(), use, key_id);
  }
}

/// Null unless map and identity consent. Whether they do may not be known: then nothing is kept.
std::unique_ptr<PassTap> MakePassTap(const v1::OpenSession& open, const Caller& caller,
                                     PassWriter& passes) {
  NewPass pass{.tenant = caller.principal.tenant,
               .map_name = open.map_name(),
               .identity_name = caller.principal.name,
               .vehicle_id = open.vehicle_id()};
  const absl::StatusOr<bool> may =
      passes.store().MayKeep(pass.tenant, pass.map_name, pass.identity_name);
  if (!may.ok() || !*may) return nullptr;
  return std::make_unique<PassTap>(passes, std::move(pass), open.rig());
}

}  // namespace

absl::StatusOr<std::shared_ptr<Session>> OpenSession(const v1::OpenSession& open,
                                                     const Caller& caller,
                                                     const SessionSources& sources) {
  const std::string& tenant = caller.principal.tenant;
  absl::StatusOr<convert::SessionRequest> request = convert::FromProto(open);
  if (!request.ok()) return request.status();
  TicketBinding binding = BindingOf(caller.principal, open);
  OpenedTicket ticket = OpenTicket(open, binding, sources.context);
  absl::StatusOr<LoadedMap> map = AcquireMapOf(ticket, *request, tenant, sources);
  if (!map.ok()) return map.status();
  absl::StatusOr<std::optional<InitialPose>> initial_pose =
      convert::InitialPoseFromProto(open, map->map->info().anchor);
  if (!initial_pose.ok()) return initial_pose.status();
  absl::StatusOr<std::shared_ptr<SessionInfo>> info =
      MakeInfo(open, caller, map->record, EpochOf(*request, ticket));
  if (!info.ok()) return info.status();
  SessionStart start{.info = *std::move(info),
                     .map = *std::move(map),
                     .rig = std::move(request->rig),
                     .options = request->options,
                     .initial_pose = *std::move(initial_pose),
                     .binding = std::move(binding),
                     .ticket_use = ticket.use,
                     .ticket = std::nullopt,
                     .answered_until = std::nullopt,
                     .passes = MakePassTap(open, caller, sources.passes)};
  if (ticket.use == TicketUse::kAccepted) start.ticket = std::move(ticket.content);
  if (open.has_answered_sequence_number()) start.answered_until = open.answered_sequence_number();
  absl::StatusOr<std::shared_ptr<Session>> session =
      Session::Create(sources.context, std::move(start));
  if (!session.ok()) return WithPrefix("open: ", session.status());
  TellTicketUse(**session, ticket.key_id, sources.context.metrics);
  // A recording that began in the middle of a session could not be replayed.
  if ((*session)->ticket_use() == TicketUse::kAccepted) return session;
  if (auto subscriber = sources.recordings.Take(tenant, open.vehicle_id())) {
    (*session)->Record(std::move(subscriber), open);
  }
  return session;
}

}  // namespace dcloc::server
