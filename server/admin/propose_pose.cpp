#include "server/admin/propose_pose.h"

#include <utility>

#include "server/base/check.h"
#include "server/convert/initial_pose.h"
#include "server/convert/position_fix.h"
#include "server/convert/scan.h"

namespace dcloc::server {
namespace {

absl::Status Propose(Session& session, const v1::ProposePoseRequest& request,
                     v1::ProposePoseResponse* response) {
  if (!request.has_pose()) return Missing("pose");
  absl::Status status = convert::FromProto(request.pose(), "pose").status();
  if (status.ok() && request.stamp_ns() != 0) {
    status = convert::CheckStamp("stamp_ns", request.stamp_ns());
  }
  if (!status.ok()) return status;
  v1::PositionFix fix;
  fix.set_stamp_ns(request.stamp_ns());
  *fix.mutable_map_pose() = request.pose();
  const absl::StatusOr<FixAnswer> answer = session.ProposePose(std::move(fix));
  if (!answer.ok()) return answer.status();
  if (!answer->use.ok()) return answer->use.status();
  convert::ToProto(*answer, response->mutable_answer());
  return absl::OkStatus();
}

}  // namespace

void ProposePose(const std::shared_ptr<Session>& session, const v1::ProposePoseRequest& request,
                 v1::ProposePoseResponse* response,
                 absl::AnyInvocable<void(const absl::Status&)> end) {
  session->strand().Post([held = session, &request, response, end = std::move(end)]() mutable {
    const absl::Status status = Propose(*held, request, response);
    held.reset();  // the caller may delete its map's version next
    end(status);
  });
}

}  // namespace dcloc::server
