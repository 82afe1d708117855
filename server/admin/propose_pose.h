#pragma once

#include <memory>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "dcloc/v1/admin_service.pb.h"
#include "server/sessions/session.h"

namespace dcloc::server {

/// Gives `session` the pose as a position fix, on its strand. `end` is called there with OK and
/// what became of the pose in `response`; InvalidArgument names the field, the value and the bound;
/// FailedPrecondition before the first scan, which alone tells the vehicle's clock;
/// ResourceExhausted above the rate of fixes. Both messages outlive the call of `end`.
void ProposePose(const std::shared_ptr<Session>& session, const v1::ProposePoseRequest& request,
                 v1::ProposePoseResponse* response,
                 absl::AnyInvocable<void(const absl::Status&)> end);

}  // namespace dcloc::server
