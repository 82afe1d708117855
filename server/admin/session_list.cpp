#include "server/admin/session_list.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "server/convert/answer.h"
#include "server/convert/geometry.h"
#include "server/convert/page.h"
#include "server/convert/time.h"

namespace dcloc::server {
namespace {

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

void SetLast(const SessionInfo& info, v1::Session* session) {
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
}

}  // namespace

void Describe(const ListedSession& listed, const std::string& replica, v1::Session* session) {
  const SessionInfo& info = *listed.info;
  const SessionDescription& description = info.description;
  session->set_session_id(description.session_id);
  session->set_vehicle_id(description.vehicle_id);
  session->set_peer(description.caller.peer);
  session->set_map_name(description.map_name);
  session->set_map_version(info.map_version);
  *session->mutable_open_time() = convert::ToProto(description.open_time);
  session->set_detached(listed.detached);
  session->set_replica(replica);
  SetCounts(info, session);
  SetLast(info, session);
  const std::chrono::nanoseconds idle = SessionInfo::Clock::now() - info.last_activity.load();
  session->set_idle_duration_ns(idle.count());
}

absl::Status ListSessions(const SessionRegistry& registry, const Principal& principal,
                          const std::string& replica, const v1::ListSessionsRequest& request,
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
    Describe(listed, replica, response->add_sessions());
  }
  return absl::OkStatus();
}

void MergePages(int page_size, std::vector<ReplicaAnswer<v1::ListSessionsResponse>> others,
                v1::ListSessionsResponse* response) {
  bool more = !response->next_page_token().empty();
  auto& sessions = *response->mutable_sessions();
  for (ReplicaAnswer<v1::ListSessionsResponse>& other : others) {
    if (!other.status.ok()) {
      v1::ReplicaFault* fault = response->add_unanswered();
      fault->set_address(other.address);
      fault->set_fault(other.status.error_message());
      continue;
    }
    more = more || !other.response.next_page_token().empty();
    for (v1::Session& session : *other.response.mutable_sessions()) {
      *sessions.Add() = std::move(session);
    }
  }
  std::sort(
      sessions.pointer_begin(), sessions.pointer_end(),
      [](const v1::Session* a, const v1::Session* b) { return a->session_id() < b->session_id(); });
  // Each page has what its server has of the first ids, so what they have together begins with
  // these.
  more = more || sessions.size() > page_size;
  if (sessions.size() > page_size) {
    sessions.DeleteSubrange(page_size, sessions.size() - page_size);
  }
  response->clear_next_page_token();
  if (more && !sessions.empty()) response->set_next_page_token(sessions.rbegin()->session_id());
}

}  // namespace dcloc::server
