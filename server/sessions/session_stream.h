#pragma once

#include <grpcpp/support/status.h>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::server {

/// The stream that a session is attached to, as those see it who may end it. Thread-safe.
class SessionStream {
 public:
  virtual ~SessionStream() = default;

  /// Tells the client, if it could do something about it, that the session is about to end.
  virtual void Announce(const v1::SessionEnding& ending) = 0;

  /// Reads no more, answers what was read, then ends with `status`.
  virtual void End(grpc::Status status) = 0;

  /// Another stream has the session now: answers no more, then ends with `status`.
  virtual void Displace(grpc::Status status) = 0;

  /// Ends at once, also when the client does not read.
  virtual void Abort() = 0;
};

}  // namespace dcloc::server
