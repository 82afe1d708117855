#pragma once

#include <memory>
#include <string>

#include "server/identity/principal.h"
#include "server/identity/usage.h"

namespace dcloc::server {

/// Who opened a session, and from where.
struct Caller {
  Principal principal;
  std::string peer;      ///< the address as the transport names it
  std::string trace_id;  ///< of the W3C traceparent that came with the call; empty without one
  /// The right to hold the session; given back when the last copy goes.
  std::shared_ptr<const SessionPermit> permit;
};

}  // namespace dcloc::server
