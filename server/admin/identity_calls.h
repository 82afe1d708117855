#pragma once

#include "absl/status/status.h"
#include "dcloc/v1/admin_service.pb.h"
#include "server/identity/identity_store.h"

namespace dcloc::server {

/// A page of the identities, by ascending id. InvalidArgument, and the store's own errors.
absl::Status ListIdentities(IdentityStore& identities, const v1::ListIdentitiesRequest& request,
                            v1::ListIdentitiesResponse* response);

}  // namespace dcloc::server
