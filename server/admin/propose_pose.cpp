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
  if (status.ok() && request.stamp_ns() != 0)
    status = convert::CheckStamp("stamp_ns", request.stamp_ns());
  if (!status.ok()) return status;
  const std::optional<Stamp> last_stamp = session.last_stamp();
  if (!last_stamp) {
    return absl::FailedPreconditionError("no scan of the session has been localized yet");
  }
  v1::PositionFix fix;
  fix.set_stamp_ns(request.stamp_ns() != 0 ? request.stamp_ns()
                                           : last_stamp->time_since_epoch().count());
  *fix.mutable_map_pose() = request.pose();
  session.TakeFix(fix, [&](const FixAnswer& answer) {
    status = answer.use.status();
    convert::ToProto(answer, response->mutable_answer());
  });
  return status;
}

}  // namespace

void ProposePose(const std::shared_ptr<Session>& session, const v1::ProposePoseRequest& request,
                 v1::ProposePoseResponse* response,
                 absl::AnyInvocable<void(const absl::Status&)> end) {
  session->strand().Post([session, &request, response, end = std::move(end)]() mutable {
    end(Propose(*session, request, response));
  });
}

}  // namespace dcloc::server
