#include "server/admin/admin_service.h"

#include <memory>
#include <utility>
#include <vector>

#include "google/protobuf/util/time_util.h"
#include "server/convert/page.h"
#include "server/convert/session.h"
#include "server/unary.h"

namespace dcloc::server {
namespace {

google::protobuf::Timestamp ToTimestamp(SystemTime time) {
  return google::protobuf::util::TimeUtil::NanosecondsToTimestamp(time.time_since_epoch().count());
}

void Describe(const SessionRecord& record, v1::Session* session) {
  const SessionDescription& description = record.description;
  session->set_session_id(description.session_id);
  session->set_vehicle_id(description.vehicle_id);
  session->set_peer(description.peer);
  session->set_map_name(description.map_name);
  session->set_map_version(description.map_version);
  *session->mutable_open_time() = ToTimestamp(description.open_time);
  session->set_scan_count(record.counts.answered);
  session->set_rejected_scan_count(record.counts.rejected);
  if (const int state = record.last_state; state >= 0) {
    session->set_state(convert::ToProto(static_cast<LocalizationState>(state)));
  }
}

absl::Status ListSessions(const SessionRegistry& registry, const v1::ListSessionsRequest& request,
                          v1::ListSessionsResponse* response) {
  const absl::StatusOr<int> size = convert::PageSizeFromProto(request.page_size());
  if (!size.ok()) return size.status();
  if (absl::Status status = convert::CheckPageToken(request.page_token()); !status.ok()) {
    return status;
  }
  for (const auto& record : registry.List(request.page_token(), *size + 1)) {
    if (response->sessions_size() == *size) {
      response->set_next_page_token(response->sessions(*size - 1).session_id());
      break;
    }
    Describe(*record, response->add_sessions());
  }
  return absl::OkStatus();
}

}  // namespace

AdminService::AdminService(ServerFacts facts, SessionRegistry& registry, StorageHost host)
    : facts_(std::move(facts)), registry_(registry), host_(host) {}

grpc::ServerUnaryReactor* AdminService::GetServerState(grpc::CallbackServerContext* context,
                                                       const v1::GetServerStateRequest* /*request*/,
                                                       v1::GetServerStateResponse* response) {
  return AnswerOn(host_, context, [this, response] {
    response->set_server_version(facts_.version);
    *response->mutable_start_time() = ToTimestamp(facts_.start_time);
    response->set_worker_count(facts_.worker_count);
    response->set_session_count(registry_.count());
    response->set_max_session_count(facts_.max_session_count);
    response->set_loaded_map_count(host_.store.loaded_map_count());
    response->set_scan_count(registry_.totals().answered);
    response->set_rejected_scan_count(registry_.totals().rejected);
    response->set_stub_matcher(facts_.stub_matcher);
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* AdminService::ListSessions(grpc::CallbackServerContext* context,
                                                     const v1::ListSessionsRequest* request,
                                                     v1::ListSessionsResponse* response) {
  return AnswerOn(host_, context, [this, request, response] {
    return server::ListSessions(registry_, *request, response);
  });
}

}  // namespace dcloc::server
