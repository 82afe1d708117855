#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/server_context.h>

#include <atomic>
#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "server/identity/identity_store.h"
#include "server/identity/method_permissions.h"
#include "server/identity/principal.h"

namespace dcloc::server {

/// Authenticates and authorizes each call: the only place that does. A caller proves its identity
/// by "authorization: Bearer TOKEN" in the call's metadata, or else by a client certificate. Until
/// the first identity is created, and if none is required, everyone is an admin. Thread-safe.
///
/// Who holds manage_server may name a tenant, in "dcloc-tenant", and works in that one.
///
/// A call is checked once, when it begins; revoking a token does not end a running session. Which
/// permission an RPC needs is in `MethodPermissions`.
class AccessControl {
 public:
  /// `identities` outlives it.
  AccessControl(IdentityStore& identities, bool require_identity);

  /// The principal of a call, if it may make it. The type of `request` says which RPC it is, as
  /// each RPC has a request of its own. Unauthenticated says what is wrong with the proof,
  /// PermissionDenied which permission is missing; both are logged.
  absl::StatusOr<Principal> Authorize(const grpc::ServerContextBase& context,
                                      const google::protobuf::Descriptor* request) const;

  /// Whether it is certain that callers need a proof. Known without the store.
  bool needs_proof() const { return require_identity_ || has_identities_; }

  /// Whether everyone is an admin at this moment.
  absl::StatusOr<bool> IsOpen() const;

 private:
  absl::StatusOr<Principal> Identify(const grpc::ServerContextBase& context) const;

  IdentityStore& identities_;
  const bool require_identity_;
  mutable std::atomic<bool> has_identities_ = false;  ///< once true it stays so
  std::map<const google::protobuf::Descriptor*, MethodPermission> permissions_;
};

}  // namespace dcloc::server
