#pragma once

#include <grpcpp/support/status.h>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::server {

/// The interface through which others end the stream that a session is attached to. Thread-safe.
class SessionStream {
 public:
  virtual ~SessionStream() = default;

  /// Tells the client that the session is about to end, if the session is resumable.
  virtual void Announce(const v1::SessionEnding& ending) = 0;

  /// Stops reading, answers the scans that were read, then ends with `status`.
  virtual void End(grpc::Status status) = 0;

  /// Another stream has taken the session: stops answering and ends with `status`.
  virtual void Displace(grpc::Status status) = 0;

  /// Ends at once, also when the client does not read.
  virtual void Abort() = 0;
};

}  // namespace dcloc::server
