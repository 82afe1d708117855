#pragma once

#include <grpcpp/support/server_callback.h>

#include <memory>

#include "absl/functional/any_invocable.h"
#include "absl/status/statusor.h"
#include "dcloc/v1/localization_service.pb.h"
#include "server/localization/stream_context.h"
#include "server/sessions/session_stream.h"

namespace dcloc::server {

/// A session that is attached to a stream.
struct AttachedSession {
  std::shared_ptr<Session> session;
  bool resumed = false;
};

using AttachDone = absl::AnyInvocable<void(absl::StatusOr<AttachedSession>)>;

/// Opens or resumes the session that a stream's first message asks for, and attaches it to the
/// stream. May wait for a disk. `done` is called once: on the session's strand with the session, or
/// with the error that ends the stream. `host`, `context` and `request` live until then;
/// `principal` is who calls.
void AttachSession(const StreamContext& host, const grpc::CallbackServerContext& context,
                   const Principal& principal, const v1::LocalizeRequest& request,
                   std::shared_ptr<SessionStream> stream, AttachDone done);

}  // namespace dcloc::server
