#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "dcloc/v1/localization_service.pb.h"
#include "server/identity/caller.h"
#include "server/passes/pass_writer.h"
#include "server/sessions/session.h"

namespace dcloc::server {

/// What opening a session needs; outlives the call.
struct SessionSources {
  MapStore& store;
  RecordingRequests& recordings;
  PassWriter& passes;
  SessionContext context;
};

/// Opens the session that a client asks for. Loads the map, which may take a while. Errors name the
/// field: InvalidArgument, NotFound (map), FailedPrecondition (no active version, no anchor),
/// DataLoss.
absl::StatusOr<std::shared_ptr<Session>> OpenSession(const v1::OpenSession& open,
                                                     const Caller& caller,
                                                     const SessionSources& sources);

}  // namespace dcloc::server
