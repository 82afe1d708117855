#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "dcloc/v1/admin_service.pb.h"
#include "server/replicas/replicas.h"
#include "server/sessions/session_registry.h"

namespace dcloc::server {

/// Fills `session`, which is at `replica`.
void Describe(const ListedSession& listed, const std::string& replica, v1::Session* session);

/// The page of this server's own sessions. InvalidArgument names the field.
absl::Status ListSessions(const SessionRegistry& registry, const Principal& principal,
                          const std::string& replica, const v1::ListSessionsRequest& request,
                          v1::ListSessionsResponse* response);

/// Makes one page of this server's, which `response` has, and those of others.
void MergePages(int page_size, std::vector<ReplicaAnswer<v1::ListSessionsResponse>> others,
                v1::ListSessionsResponse* response);

}  // namespace dcloc::server
