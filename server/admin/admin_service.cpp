#include "server/admin/admin_service.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/admin/identity_calls.h"
#include "server/admin/operation_calls.h"
#include "server/admin/propose_pose.h"
#include "server/admin/record_elsewhere.h"
#include "server/admin/relay.h"
#include "server/admin/replica_answers.h"
#include "server/admin/session_list.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/page.h"
#include "server/convert/time.h"
#include "server/rpc/refused_stream.h"
#include "server/rpc/unary.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxReason = 200;
using AsyncAdmin = v1::AdminService::StubInterface::async_interface;

/// Each may hold some megabytes for a caller who reads slowly.
constexpr int kMaxRecordingCount = 16;

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

void SetAnswer(ReplicaAnswer<v1::GetServerStateResponse> answer, v1::Replica* replica) {
  replica->set_address(answer.address);
  if (answer.status.ok()) {
    *replica->mutable_state() = std::move(answer.response);
  } else {
    replica->set_fault(answer.status.error_message());
  }
}

}  // namespace

AdminService::AdminService(ServerFacts facts, SessionRegistry& registry,
                           RecordingRequests& recordings, IdentityStore& identities,
                           RpcContext host, Replicas& replicas, DrainControl drain,
                           std::function<ServerGauges()> gauges)
    : facts_(std::move(facts)),
      registry_(registry),
      recordings_(recordings),
      identities_(identities),
      host_(host),
      replicas_(replicas),
      drain_(std::move(drain)),
      gauges_(std::move(gauges)) {
  AwaitRequests(host.awaited_requests, &AdminService::ListReplicas, &AdminService::GetServerState,
                &AdminService::ListSessions, &AdminService::GetSession, &AdminService::EndSession,
                &AdminService::WatchSession, &AdminService::RecordSession,
                &AdminService::ProposePose, &AdminService::ListOperations,
                &AdminService::ListIdentities, &AdminService::RevokeIdentity, &AdminService::Drain);
}

void AdminService::Describe(v1::GetServerStateResponse* response) const {
  response->set_replica(replicas_.own_address());
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
  response->set_stub_matcher(facts_.stub_localizer);
  response->set_draining(drain_.draining());
  const ServerGauges gauges = gauges_();
  response->set_unopened_stream_count(gauges.unopened_stream_count);
  response->set_awaited_request_count(gauges.awaited_request_count);
  response->set_max_unopened_stream_count(gauges.max_unopened_stream_count);
  if (gauges.certificate_expire_time) {
    *response->mutable_certificate_expire_time() =
        convert::ToProto(*gauges.certificate_expire_time);
    response->set_certificate_fault(gauges.certificate_fault);
  }
}

std::vector<std::string> AdminService::OthersToAsk(
    const grpc::CallbackServerContext& context) const {
  return replicas_.CanHandOn(context) ? replicas_.OthersFor(context) : std::vector<std::string>();
}

template <typename Request, typename Response>
void AdminService::AskOwner(const grpc::CallbackServerContext& context, const Request& request,
                            Replicas::Method<Request, Response> method, const absl::Status& here,
                            Response* response, const UnaryDone& done) {
  replicas_.Ask<Request, Response>(OthersToAsk(context), context, request, method,
                                   replicas_.bounds().answer, [here, response, done](auto answers) {
                                     done(TakeFound(here, std::move(answers), response));
                                   });
}

template <typename Request, typename Response>
void AdminService::AskOne(std::string address, const grpc::CallbackServerContext& context,
                          const Request& request, Replicas::Method<Request, Response> method,
                          std::chrono::milliseconds bound, Response* response,
                          const UnaryDone& done) {
  replicas_.Ask<Request, Response>(
      {std::move(address)}, context, request, method, bound,
      [response, done](auto answers) { done(TakeOnly(std::move(answers), response)); });
}

grpc::ServerUnaryReactor* AdminService::ListReplicas(grpc::CallbackServerContext* context,
                                                     const v1::ListReplicasRequest* request,
                                                     v1::ListReplicasResponse* response) {
  return RunUnaryAsync(
      host_, context, request, [this, context, response](const Principal&, const UnaryDone& done) {
        replicas_.Ask<v1::GetServerStateRequest, v1::GetServerStateResponse>(
            replicas_.OthersFor(*context), *context, {}, &AsyncAdmin::GetServerState,
            replicas_.bounds().answer, [this, response, done](auto answers) {
              auto& own = answers.emplace_back();
              own.address = replicas_.own_address();
              Describe(&own.response);
              std::ranges::sort(answers, {}, [](const auto& answer) { return answer.address; });
              for (auto& answer : answers) SetAnswer(std::move(answer), response->add_replicas());
              done(absl::OkStatus());
            });
      });
}

grpc::ServerUnaryReactor* AdminService::GetServerState(grpc::CallbackServerContext* context,
                                                       const v1::GetServerStateRequest* request,
                                                       v1::GetServerStateResponse* response) {
  return RunUnaryAsync(host_, context, request,
                       [this, context, request, response](const Principal&, const UnaryDone& done) {
                         const auto named = replicas_.Named(*context, request->replica());
                         if (!named.ok()) return done(named.status());
                         if (named->empty()) {
                           Describe(response);
                           return done(absl::OkStatus());
                         }
                         AskOne(named->front(), *context, *request, &AsyncAdmin::GetServerState,
                                replicas_.bounds().answer, response, done);
                       });
}

grpc::ServerUnaryReactor* AdminService::ListSessions(grpc::CallbackServerContext* context,
                                                     const v1::ListSessionsRequest* request,
                                                     v1::ListSessionsResponse* response) {
  return RunUnaryAsync(
      host_, context, request,
      [this, context, request, response](const Principal& principal, const UnaryDone& done) {
        const absl::Status status =
            server::ListSessions(registry_, principal, replicas_.own_address(), *request, response);
        const std::vector<std::string> others = replicas_.OthersFor(*context);
        if (!status.ok() || request->this_replica_only() || others.empty()) return done(status);
        replicas_.Ask<v1::ListSessionsRequest, v1::ListSessionsResponse>(
            others, *context, *request, &AsyncAdmin::ListSessions, replicas_.bounds().answer,
            [request, response, done](auto pages) {
              MergePages(*convert::PageSizeFromProto(request->page_size()), std::move(pages),
                         response);
              done(absl::OkStatus());
            });
      });
}

grpc::ServerUnaryReactor* AdminService::GetSession(grpc::CallbackServerContext* context,
                                                   const v1::GetSessionRequest* request,
                                                   v1::GetSessionResponse* response) {
  return RunUnaryAsync(
      host_, context, request,
      [this, context, request, response](const Principal& principal, const UnaryDone& done) {
        const auto session = registry_.Get(principal.tenant, request->session_id());
        if (session.ok()) {
          server::Describe(*session, replicas_.own_address(), response->mutable_session());
        }
        if (!absl::IsNotFound(session.status())) return done(session.status());
        AskOwner(*context, *request, &AsyncAdmin::GetSession, session.status(), response, done);
      });
}

grpc::ServerUnaryReactor* AdminService::EndSession(grpc::CallbackServerContext* context,
                                                   const v1::EndSessionRequest* request,
                                                   v1::EndSessionResponse* response) {
  return RunUnaryAsync(
      host_, context, request,
      [this, context, request, response](const Principal& principal, const UnaryDone& done) {
        const absl::Status status = server::EndSession(registry_, principal, *request);
        if (!absl::IsNotFound(status)) return done(status);
        AskOwner(*context, *request, &AsyncAdmin::EndSession, status, response, done);
      });
}

grpc::ServerWriteReactor<v1::WatchSessionResponse>* AdminService::WatchSession(
    grpc::CallbackServerContext* context, const v1::WatchSessionRequest* request) {
  return BeginWithinMemory<grpc::ServerWriteReactor<v1::WatchSessionResponse>>(
      [&] { return BeginWatching(context, request); });
}

WatchStream* AdminService::BeginWatching(grpc::CallbackServerContext* context,
                                         const v1::WatchSessionRequest* request) {
  std::shared_ptr<WatchStream> stream = WatchStream::Start(host_, context);
  // The call lives until `Begin`, and so do the context and the request.
  stream->BeginOnPool([this, context, request, stream] {
    const auto principal = host_.access.Authorize(*context, v1::WatchSessionRequest::descriptor());
    if (!principal.ok()) return stream->Begin(principal.status());
    const auto session = registry_.Get(principal->tenant, request->session_id());
    if (absl::IsNotFound(session.status())) {
      return WatchElsewhere(context, *request, session.status(), stream);
    }
    if (request->position_fixes()) stream->IncludeFixAnswers();
    if (session.ok() && request->scans()) {
      stream->IncludeScans(session->info->description.rig);
    }
    stream->Begin(session.ok() ? session->info->feed.Subscribe(stream) : session.status());
  });
  return stream.get();
}

void AdminService::WatchElsewhere(grpc::CallbackServerContext* context,
                                  const v1::WatchSessionRequest& request, const absl::Status& here,
                                  const std::shared_ptr<WatchStream>& stream) {
  // A stop waits for no session of another server.
  shutdown_hooks_.Add<WatchStream>(stream, [](WatchStream& watch) { watch.EndAtStop(); });
  FindReplicaOf(
      replicas_, OthersToAsk(*context), *context, request.session_id(), here,
      [this, context, &request, stream](const absl::StatusOr<std::string>& address) {
        if (!address.ok()) return stream->Begin(address.status());
        absl::StatusOr<Replicas::Line> line = replicas_.Call(*address, *context);
        if (!line.ok()) return stream->Begin(line.status());
        using WatchRelay = Relay<v1::WatchSessionRequest, v1::WatchSessionResponse>;
        WatchRelay::Start(
            *std::move(line), request, &AsyncAdmin::WatchSession, replicas_.bounds().answer,
            {.on_begin = [] {},
             .on_message = [stream](auto message) { stream->OnRelayed(std::move(message)); },
             .on_end = [stream](const grpc::Status& end) { stream->OnRelayEnd(end); }});
        stream->Begin(absl::OkStatus());
      });
}

grpc::ServerWriteReactor<v1::RecordSessionResponse>* AdminService::RecordSession(
    grpc::CallbackServerContext* context, const v1::RecordSessionRequest* request) {
  return BeginWithinMemory<grpc::ServerWriteReactor<v1::RecordSessionResponse>>(
      [&] { return BeginRecording(context, request); });
}

RecordStream* AdminService::BeginRecording(grpc::CallbackServerContext* context,
                                           const v1::RecordSessionRequest* request) {
  std::shared_ptr<RecordStream> stream =
      RecordStream::Start(host_, context, absl::StrCat("dcloc-server ", facts_.version));
  // The call lives until `Begin`, and so do the context and the request.
  stream->BeginOnPool([this, context, request, stream] {
    const auto principal = host_.access.Authorize(*context, v1::RecordSessionRequest::descriptor());
    absl::Status status = principal.status();
    if (status.ok()) status = CheckId("vehicle_id", request->vehicle_id());
    std::shared_ptr<void> slot = recording_slots_.Take(kMaxRecordingCount);
    if (status.ok() && slot == nullptr) {
      status = absl::ResourceExhaustedError(
          absl::StrFormat("%d recordings are under way, which is the limit", kMaxRecordingCount));
    }
    if (request->position_fixes()) stream->IncludeFixes();
    // A stop waits for no vehicle that has not come, and for no session of another server.
    shutdown_hooks_.Add<RecordStream>(stream, [](RecordStream& record) { record.EndAtStop(); });
    // Who cannot be spoken for elsewhere records here alone.
    const std::vector<std::string> others = OthersToAsk(*context);
    const auto begin = [this, context, request, stream, caller = principal,
                        slot = std::move(slot)](const absl::Status& armed) {
      if (caller.ok()) host_.operations.Note(*context, *caller, *request, armed);
      if (armed.ok()) recordings_.Add(caller->tenant, request->vehicle_id(), stream);
      // A session that has opened elsewhere by now is the one.
      if (stream->IsDecidedAgainst(RecordElection::kHere)) recordings_.Forget(*stream);
      stream->Begin(armed, slot);
    };
    if (!status.ok() || others.empty()) return begin(status);
    RecordElsewhere(replicas_, recordings_, others, *context, *request, stream, begin);
  });
  return stream.get();
}

grpc::ServerUnaryReactor* AdminService::ProposePose(grpc::CallbackServerContext* context,
                                                    const v1::ProposePoseRequest* request,
                                                    v1::ProposePoseResponse* response) {
  return RunUnaryAsync(
      host_, context, request,
      [this, context, request, response](const Principal& principal, const UnaryDone& done) {
        const auto session = registry_.GetSession(principal.tenant, request->session_id());
        if (session.ok()) {
          // Vehicles wait for the strand's threads, so the call ends on one of the host's.
          return server::ProposePose(*session, *request, response,
                                     [this, done](const absl::Status& status) {
                                       host_.pool.Post([done, status] { done(status); });
                                     });
        }
        if (!absl::IsNotFound(session.status())) return done(session.status());
        FindReplicaOf(replicas_, OthersToAsk(*context), *context, request->session_id(),
                      session.status(),
                      [this, context, request, response, done](const auto& address) {
                        if (!address.ok()) return done(address.status());
                        AskOne(*address, *context, *request, &AsyncAdmin::ProposePose,
                               replicas_.bounds().search, response, done);
                      });
      });
}

grpc::ServerUnaryReactor* AdminService::ListOperations(grpc::CallbackServerContext* context,
                                                       const v1::ListOperationsRequest* request,
                                                       v1::ListOperationsResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return server::ListOperations(host_.operations, principal.tenant, *request, response);
  });
}

grpc::ServerUnaryReactor* AdminService::ListIdentities(grpc::CallbackServerContext* context,
                                                       const v1::ListIdentitiesRequest* request,
                                                       v1::ListIdentitiesResponse* response) {
  return RunUnary(host_, context, request, [this, request, response] {
    return server::ListIdentities(identities_, *request, response);
  });
}

grpc::ServerUnaryReactor* AdminService::RevokeIdentity(grpc::CallbackServerContext* context,
                                                       const v1::RevokeIdentityRequest* request,
                                                       v1::RevokeIdentityResponse* /*response*/) {
  return RunUnary(host_, context, request,
                  [this, request] { return identities_.Revoke(request->id()); });
}

grpc::ServerUnaryReactor* AdminService::Drain(grpc::CallbackServerContext* context,
                                              const v1::DrainRequest* request,
                                              v1::DrainResponse* response) {
  return RunUnaryAsync(host_, context, request,
                       [this, context, request, response](const Principal&, const UnaryDone& done) {
                         const auto named = replicas_.Named(*context, request->replica());
                         if (!named.ok()) return done(named.status());
                         if (named->empty()) {
                           response->set_session_count(drain_.drain());
                           response->set_replica(replicas_.own_address());
                           return done(absl::OkStatus());
                         }
                         AskOne(named->front(), *context, *request, &AsyncAdmin::Drain,
                                replicas_.bounds().answer, response, done);
                       });
}

}  // namespace dcloc::server
