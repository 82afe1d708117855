#include "server/admin/admin_service.h"

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/admin/identity_calls.h"
#include "server/admin/operation_calls.h"
#include "server/admin/propose_pose.h"
#include "server/admin/watch_stream.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/answer.h"
#include "server/convert/geometry.h"
#include "server/convert/page.h"
#include "server/convert/time.h"
#include "server/rpc/unary.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxReason = 200;
/// Each may hold some megabytes for a caller who reads slowly.
constexpr int kMaxRecordingCount = 16;

void SetCounts(const SessionInfo& info, v1::Session* session) {
  session->set_scan_count(info.counts.answered);
  session->set_rejected_scan_count(info.counts.rejected);
  session->set_repeated_scan_count(info.counts.repeated);
  session->set_dropped_scan_count(info.counts.dropped);
  session->set_missing_scan_count(info.missing_scan_count);
  session->set_resume_count(info.resume_count);
  session->set_position_fix_count(info.position_fix_count);
  session->set_pose_reset_count(info.pose_reset_count);
}

void Describe(const ListedSession& listed, v1::Session* session) {
  const SessionInfo& info = *listed.info;
  const SessionDescription& description = info.description;
  session->set_session_id(description.session_id);
  session->set_vehicle_id(description.vehicle_id);
  session->set_peer(description.caller.peer);
  session->set_map_name(description.map_name);
  session->set_map_version(info.map_version);
  *session->mutable_open_time() = convert::ToProto(description.open_time);
  session->set_detached(listed.detached);
  SetCounts(info, session);
  if (const int state = info.last_state; state >= 0) {
    session->set_state(convert::ToProto(static_cast<LocalizationState>(state)));
  }
  if (const std::int64_t last = info.last_sequence_number; last >= 0) {
    session->set_last_sequence_number(last);
  }
  session->set_last_stamp_age_ns(info.last_stamp_age_ns);
  if (const LastHealth::Value last = info.health.Get(); last.rig != nullptr) {
    convert::ToProto(last.health, *last.rig, session->mutable_health());
  }
  if (const std::optional<LastPose::Value> last = info.pose.Get()) {
    convert::ToProto(last->T_map_vehicle, last->covariance, session->mutable_pose());
    session->set_pose_stamp_ns(last->stamp_ns);
  }
  const std::chrono::nanoseconds idle = SessionInfo::Clock::now() - info.last_activity.load();
  session->set_idle_duration_ns(idle.count());
}

absl::Status EndSession(SessionRegistry& registry, const Principal& principal,
                        const v1::EndSessionRequest& request) {
  if (request.reason().size() > kMaxReason) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "reason has %d characters; it must have at most %d", request.reason().size(), kMaxReason));
  }
  v1::SessionEnding ending;
  ending.set_reason(v1::SESSION_END_REASON_OPERATOR);
  ending.set_message(request.reason().empty()
                         ? "an operator ended it"
                         : absl::StrCat("an operator ended it: ", request.reason()));
  return registry.End(request.session_id(), principal.tenant, ending);
}

absl::Status ListSessions(const SessionRegistry& registry, const Principal& principal,
                          const v1::ListSessionsRequest& request,
                          v1::ListSessionsResponse* response) {
  const absl::StatusOr<int> size = convert::PageSizeFromProto(request.page_size());
  if (!size.ok()) return size.status();
  if (absl::Status status = convert::CheckPageToken(request.page_token()); !status.ok()) {
    return status;
  }
  for (const ListedSession& listed :
       registry.List(principal.tenant, request.page_token(), *size + 1)) {
    if (response->sessions_size() == *size) {
      response->set_next_page_token(response->sessions(*size - 1).session_id());
      break;
    }
    Describe(listed, response->add_sessions());
  }
  return absl::OkStatus();
}

}  // namespace

AdminService::AdminService(ServerFacts facts, SessionRegistry& registry,
                           RecordingRequests& recordings, IdentityStore& identities,
                           StorageHost host, DrainControl drain,
                           std::function<ServerGauges()> gauges)
    : facts_(std::move(facts)),
      registry_(registry),
      recordings_(recordings),
      identities_(identities),
      host_(host),
      drain_(std::move(drain)),
      gauges_(std::move(gauges)) {}

void AdminService::Describe(v1::GetServerStateResponse* response) const {
  response->set_server_version(facts_.version);
  *response->mutable_start_time() = convert::ToProto(facts_.start_time);
  response->set_worker_count(facts_.worker_count);
  response->set_session_count(registry_.count());
  response->set_detached_session_count(registry_.detached_count());
  response->set_max_session_count(registry_.max_session_count());
  response->set_loaded_map_count(host_.store.loaded_map_count());
  response->set_scan_count(registry_.totals().answered);
  response->set_rejected_scan_count(registry_.totals().rejected);
  response->set_dropped_scan_count(registry_.totals().dropped);
  response->set_repeated_scan_count(registry_.totals().repeated);
  response->set_resume_count(registry_.resume_count());
  response->set_stub_matcher(facts_.stub_matcher);
  response->set_draining(drain_.draining());
  const ServerGauges gauges = gauges_();
  response->set_unopened_stream_count(gauges.unopened_stream_count);
  response->set_max_unopened_stream_count(gauges.max_unopened_stream_count);
  if (gauges.certificate_expire_time) {
    *response->mutable_certificate_expire_time() =
        convert::ToProto(*gauges.certificate_expire_time);
    response->set_certificate_fault(gauges.certificate_fault);
  }
}

grpc::ServerUnaryReactor* AdminService::GetServerState(grpc::CallbackServerContext* context,
                                                       const v1::GetServerStateRequest* request,
                                                       v1::GetServerStateResponse* response) {
  return AnswerOn(host_, context, request, [this, response] {
    Describe(response);
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* AdminService::ListSessions(grpc::CallbackServerContext* context,
                                                     const v1::ListSessionsRequest* request,
                                                     v1::ListSessionsResponse* response) {
  return AnswerOn(host_, context, request, [this, request, response](const Principal& principal) {
    return server::ListSessions(registry_, principal, *request, response);
  });
}

grpc::ServerUnaryReactor* AdminService::GetSession(grpc::CallbackServerContext* context,
                                                   const v1::GetSessionRequest* request,
                                                   v1::GetSessionResponse* response) {
  return AnswerOn(host_, context, request, [this, request, response](const Principal& principal) {
    const auto session = registry_.Get(principal.tenant, request->session_id());
    if (session.ok()) server::Describe(*session, response->mutable_session());
    return session.status();
  });
}

grpc::ServerUnaryReactor* AdminService::EndSession(grpc::CallbackServerContext* context,
                                                   const v1::EndSessionRequest* request,
                                                   v1::EndSessionResponse* /*response*/) {
  return AnswerOn(host_, context, request, [this, request](const Principal& principal) {
    return server::EndSession(registry_, principal, *request);
  });
}

grpc::ServerWriteReactor<v1::WatchSessionResponse>* AdminService::WatchSession(
    grpc::CallbackServerContext* context, const v1::WatchSessionRequest* request) {
  std::shared_ptr<WatchStream> stream = WatchStream::Start(host_, context);
  // The call lives until `Begin`, and so do the context and the request.
  host_.pool.Post([this, context, request, stream] {
    const auto principal = host_.access.Authorize(*context, v1::WatchSessionRequest::descriptor());
    absl::Status status = principal.status();
    if (status.ok()) {
      const auto session = registry_.Get(principal->tenant, request->session_id());
      status = session.status();
      if (request->position_fixes()) stream->TakeFixAnswers();
      if (status.ok()) session->info->feed.Subscribe(stream);
    }
    stream->Begin(status);
  });
  return stream.get();
}

grpc::ServerWriteReactor<v1::RecordSessionResponse>* AdminService::RecordSession(
    grpc::CallbackServerContext* context, const v1::RecordSessionRequest* request) {
  std::shared_ptr<RecordStream> stream =
      RecordStream::Start(host_, context, absl::StrCat("dcloc-server ", facts_.version));
  // The call lives until `Begin`, and so do the context and the request.
  host_.pool.Post([this, context, request, stream] {
    const auto principal = host_.access.Authorize(*context, v1::RecordSessionRequest::descriptor());
    absl::Status status = principal.status();
    if (status.ok()) status = CheckId("vehicle_id", request->vehicle_id());
    std::shared_ptr<void> slot = recording_slots_.Take(kMaxRecordingCount);
    if (status.ok() && slot == nullptr) {
      status = absl::ResourceExhaustedError(
          absl::StrFormat("%d recordings are under way, which is the limit", kMaxRecordingCount));
    }
    if (request->position_fixes()) stream->TakeFixes();
    if (status.ok()) recordings_.Add(principal->tenant, request->vehicle_id(), stream);
    if (principal.ok()) host_.operations.Note(*context, *principal, *request, status);
    stream->Begin(status, std::move(slot));
  });
  return stream.get();
}

grpc::ServerUnaryReactor* AdminService::ProposePose(grpc::CallbackServerContext* context,
                                                    const v1::ProposePoseRequest* request,
                                                    v1::ProposePoseResponse* response) {
  return BeginAnswerOn(
      host_, context, request, [this, request, response](UnaryEnd<v1::ProposePoseRequest> end) {
        const auto session = registry_.GetSession(end.principal().tenant, request->session_id());
        if (!session.ok()) return end(session.status());
        // Vehicles wait for the strand's threads, so the call ends on one of the host's.
        server::ProposePose(
            *session, *request, response,
            [this, end = std::move(end)](const absl::Status& status) mutable {
              host_.pool.Post([status, end = std::move(end)]() mutable { end(status); });
            });
      });
}

grpc::ServerUnaryReactor* AdminService::ListOperations(grpc::CallbackServerContext* context,
                                                       const v1::ListOperationsRequest* request,
                                                       v1::ListOperationsResponse* response) {
  return AnswerOn(host_, context, request, [this, request, response](const Principal& principal) {
    return server::ListOperations(host_.operations, principal.tenant, *request, response);
  });
}

grpc::ServerUnaryReactor* AdminService::ListIdentities(grpc::CallbackServerContext* context,
                                                       const v1::ListIdentitiesRequest* request,
                                                       v1::ListIdentitiesResponse* response) {
  return AnswerOn(host_, context, request, [this, request, response] {
    return server::ListIdentities(identities_, *request, response);
  });
}

grpc::ServerUnaryReactor* AdminService::RevokeIdentity(grpc::CallbackServerContext* context,
                                                       const v1::RevokeIdentityRequest* request,
                                                       v1::RevokeIdentityResponse* /*response*/) {
  return AnswerOn(host_, context, request,
                  [this, request] { return identities_.Revoke(request->id()); });
}

grpc::ServerUnaryReactor* AdminService::Drain(grpc::CallbackServerContext* context,
                                              const v1::DrainRequest* request,
                                              v1::DrainResponse* response) {
  return AnswerOn(host_, context, request, [this, response] {
    response->set_session_count(drain_.drain());
    return absl::OkStatus();
  });
}

}  // namespace dcloc::server
