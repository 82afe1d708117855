#include "server/localization/attach_session.h"

#include <grpcpp/server_context.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/traceparent.h"
#include "server/base/within_memory.h"

namespace dcloc::server {
namespace {

absl::StatusOr<Caller> CallerOf(const grpc::CallbackServerContext& context,
                                const Principal& principal, const v1::OpenSession& open) {
  if (absl::Status status = CheckVehicle(principal, open.vehicle_id()); !status.ok()) {
    return status;
  }
  return Caller{.principal = principal,
                .peer = context.peer(),
                .trace_id = TraceIdOf(context),
                .permit = nullptr};
}

/// A new session, with its right to be there.
absl::StatusOr<std::shared_ptr<Session>> OpenNew(const StreamContext& host, Caller caller,
                                                 const v1::OpenSession& open,
                                                 const std::shared_ptr<SessionStream>& stream) {
  absl::StatusOr<std::shared_ptr<const SessionPermit>> permit =
      host.usages.TakeSession(caller.principal);
  if (!permit.ok()) return permit.status();
  caller.permit = *std::move(permit);
  absl::StatusOr<std::shared_ptr<Session>> session = OpenSession(open, caller, host.sessions);
  if (!session.ok()) return session.status();
  absl::Status status = host.registry.Add((*session)->info(), *session, stream);
  if (!status.ok()) return status;
  return session;
}

/// The session of a resume token, unless the vehicle has gone on elsewhere since then.
absl::StatusOr<std::shared_ptr<Session>> FindToResume(const SessionRegistry& registry,
                                                      const Caller& caller,
                                                      const v1::OpenSession& open) {
  absl::StatusOr<std::shared_ptr<Session>> session =
      registry.Find(open.resume_token(), caller.principal, open.vehicle_id());
  if (!session.ok()) return session;
  const std::int64_t epoch = (*session)->info()->description.epoch;
  if (epoch >= open.epoch()) return session;
  return absl::NotFoundError(absl::StrCat("the session is stale: its epoch is ", epoch,
                                          ", and the vehicle has had ", open.epoch()));
}

/// Takes a session over from the stream that has it. On its strand, so that what that stream has
/// begun is done.
absl::Status TakeOver(SessionRegistry& registry, const Session& session,
                      const std::shared_ptr<SessionStream>& stream) {
  const auto before = registry.Attach(*session.info(), stream);
  if (!before.ok()) return before.status();
  if (*before != nullptr) {
    (*before)->Displace(grpc::Status(grpc::StatusCode::ABORTED,
                                     "another stream presented the session's resume token"));
  }
  return absl::OkStatus();
}

}  // namespace

void AttachSession(const StreamContext& host, const grpc::CallbackServerContext& context,
                   const Principal& principal, const v1::LocalizeRequest& request,
                   std::shared_ptr<SessionStream> stream, AttachDone done) {
  if (!request.has_open()) {
    return done(
        absl::InvalidArgumentError("open is missing; it must be the first message of a stream"));
  }
  const v1::OpenSession& open = request.open();
  absl::StatusOr<Caller> caller = CallerOf(context, principal, open);
  if (!caller.ok()) return done(caller.status());
  bool resumes = !open.resume_token().empty();
  absl::StatusOr<std::shared_ptr<Session>> session =
      resumes ? FindToResume(host.registry, *caller, open) : OpenNew(host, *caller, open, stream);
  if (resumes && absl::IsNotFound(session.status()) && !open.ticket().empty()) {
    resumes = false;
    session = OpenNew(host, *std::move(caller), open, stream);
  }
  if (!session.ok()) return done(session.status());
  // Others know the session by now and may have posted to its strand.
  Strand& strand = (*session)->strand();
  try {
    strand.Post([&registry = host.registry, resumes, stream, session = *session,
                 done = std::move(done)]() mutable {
      const absl::Status status = WithinMemory(
          [&] { return resumes ? TakeOver(registry, *session, stream) : absl::OkStatus(); });
      if (!status.ok()) return done(status);
      done(AttachedSession{.session = std::move(session), .resumed = resumes});
    });
  } catch (const std::bad_alloc&) {
    if (!resumes) host.registry.Remove(*(*session)->info(), *stream, "out of memory");
    throw;
  }
}

}  // namespace dcloc::server
