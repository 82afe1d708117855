#pragma once

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "dcloc/v1/admin_service.pb.h"
#include "server/identity/operation_log.h"

namespace dcloc::server {

/// A page of what the tenant's callers changed, newest first. InvalidArgument.
absl::Status ListOperations(const OperationLog& operations, absl::string_view tenant,
                            const v1::ListOperationsRequest& request,
                            v1::ListOperationsResponse* response);

}  // namespace dcloc::server
