#include "client/sdk/admin_client.h"

#include <grpcpp/client_context.h>

#include <map>
#include <utility>

#include "client/sdk/calls.h"
#include "client/sdk/status.h"

namespace dcloc::client {
namespace {

using Stub = v1::AdminService::Stub;

/// Hands over what comes, until it ends or `stop` is requested.
template <typename Response>
absl::Status ReadAll(grpc::ClientContext& context, grpc::ClientReader<Response>& reader,
                     const std::stop_token& stop,
                     const std::function<void(const Response&)>& on_message) {
  const std::stop_callback cancel(stop, [&context] { context.TryCancel(); });
  Response response;
  while (reader.Read(&response)) on_message(response);
  const grpc::Status status = reader.Finish();
  const bool stopped = stop.stop_requested() && status.error_code() == grpc::StatusCode::CANCELLED;
  return stopped ? absl::OkStatus() : FromGrpc(status);
}

/// The entries of all pages: `read` gets one page, `entries_of` says where its entries are.
template <typename Entry, typename Request, typename Read, typename EntriesOf>
absl::StatusOr<std::vector<Entry>> ReadPages(Request request, Read read, EntriesOf entries_of) {
  std::vector<Entry> all;
  do {
    auto page = read(request);
    if (!page.ok()) return page.status();
    for (Entry& entry : *entries_of(*page)) all.push_back(std::move(entry));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return all;
}

}  // namespace

AdminClient::AdminClient(const std::shared_ptr<grpc::Channel>& channel,
                         std::chrono::milliseconds timeout)
    : stub_(v1::AdminService::NewStub(channel)), timeout_(timeout) {}

absl::StatusOr<std::vector<v1::Replica>> AdminClient::ListReplicas() {
  const auto response = Call(*stub_, &Stub::ListReplicas, v1::ListReplicasRequest(), timeout_);
  if (!response.ok()) return response.status();
  return std::vector<v1::Replica>(response->replicas().begin(), response->replicas().end());
}

absl::StatusOr<v1::GetServerStateResponse> AdminClient::ServerState(const std::string& replica) {
  v1::GetServerStateRequest request;
  request.set_replica(replica);
  return Call(*stub_, &Stub::GetServerState, request, timeout_);
}

absl::StatusOr<int> AdminClient::Drain(const std::string& replica) {
  v1::DrainRequest request;
  request.set_replica(replica);
  const auto response = Call(*stub_, &Stub::Drain, request, timeout_);
  if (!response.ok()) return response.status();
  return response->session_count();
}

absl::StatusOr<std::vector<v1::Session>> AdminClient::ListSessions(
    std::vector<v1::ReplicaFault>* unanswered) {
  std::map<std::string, v1::ReplicaFault> faults;  // each page tells them
  std::vector<v1::Session> all;
  v1::ListSessionsRequest request;
  do {
    auto page = Call(*stub_, &Stub::ListSessions, request, timeout_);
    if (!page.ok()) return page.status();
    for (v1::Session& session : *page->mutable_sessions()) all.push_back(std::move(session));
    for (v1::ReplicaFault& fault : *page->mutable_unanswered()) {
      faults[fault.address()] = std::move(fault);
    }
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  if (unanswered == nullptr) return all;
  unanswered->clear();
  for (auto& [address, fault] : faults) unanswered->push_back(std::move(fault));
  return all;
}

absl::StatusOr<v1::Session> AdminClient::GetSession(const std::string& session_id) {
  v1::GetSessionRequest request;
  request.set_session_id(session_id);
  auto response = Call(*stub_, &Stub::GetSession, request, timeout_);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_session());
}

absl::Status AdminClient::EndSession(const std::string& session_id, const std::string& reason) {
  v1::EndSessionRequest request;
  request.set_session_id(session_id);
  request.set_reason(reason);
  return Call(*stub_, &Stub::EndSession, request, timeout_).status();
}

absl::StatusOr<v1::PositionFixAnswer> AdminClient::ProposePose(const std::string& session_id,
                                                               const v1::PoseWithCovariance& pose) {
  v1::ProposePoseRequest request;
  request.set_session_id(session_id);
  *request.mutable_pose() = pose;
  auto response = Call(*stub_, &Stub::ProposePose, request, timeout_);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_answer());
}

absl::StatusOr<std::vector<v1::Operation>> AdminClient::ListOperations() {
  return ReadPages<v1::Operation>(
      v1::ListOperationsRequest(),
      [this](const auto& request) {
        return Call(*stub_, &Stub::ListOperations, request, timeout_);
      },
      [](v1::ListOperationsResponse& page) { return page.mutable_operations(); });
}

absl::StatusOr<std::vector<v1::Identity>> AdminClient::ListIdentities() {
  return ReadPages<v1::Identity>(
      v1::ListIdentitiesRequest(),
      [this](const auto& request) {
        return Call(*stub_, &Stub::ListIdentities, request, timeout_);
      },
      [](v1::ListIdentitiesResponse& page) { return page.mutable_identities(); });
}

absl::Status AdminClient::RevokeIdentity(std::int64_t id) {
  v1::RevokeIdentityRequest request;
  request.set_id(id);
  return Call(*stub_, &Stub::RevokeIdentity, request, timeout_).status();
}

absl::Status AdminClient::WatchSession(
    const std::string& session_id, const std::stop_token& stop,
    const std::function<void(const v1::WatchSessionResponse&)>& on_answer) {
  grpc::ClientContext context;
  v1::WatchSessionRequest request;
  request.set_session_id(session_id);
  request.set_position_fixes(true);
  const auto reader = stub_->WatchSession(&context, request);
  return ReadAll(context, *reader, stop, on_answer);
}

absl::Status AdminClient::RecordSession(
    const std::string& vehicle_id, const std::stop_token& stop,
    const std::function<void()>& on_ready,
    const std::function<void(const v1::RecordSessionResponse&)>& on_message) {
  grpc::ClientContext context;
  v1::RecordSessionRequest request;
  request.set_vehicle_id(vehicle_id);
  request.set_position_fixes(true);
  const auto reader = stub_->RecordSession(&context, request);
  reader->WaitForInitialMetadata();
  on_ready();
  return ReadAll(context, *reader, stop, on_message);
}

}  // namespace dcloc::client
