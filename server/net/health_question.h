#pragma once

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace dcloc::server {

/// A connection to a server, as bytes.
class ProbeBytes {
 public:
  virtual ~ProbeBytes() = default;

  /// All of them, or why not.
  virtual absl::Status Write(absl::string_view bytes) = 0;

  /// Fills `bytes`, or says why it cannot.
  virtual absl::Status Read(absl::Span<char> bytes) = 0;
};

/// Asks `grpc.health.v1` over a new connection of HTTP/2. OK as soon as an answer begins, whatever
/// it is; else what came instead, or the connection's error. A gRPC client would do the same, but
/// with threads and queues of the very library that is asked.
absl::Status AskHealth(ProbeBytes& connection);

}  // namespace dcloc::server
