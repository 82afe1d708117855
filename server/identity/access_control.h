#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/server_context.h>

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "server/identity/identity_store.h"
#include "server/identity/method_permissions.h"
#include "server/identity/principal.h"

namespace dcloc::server {

/// Decides who calls and whether they may: the one place that does. Identities are proven by
/// "authorization: Bearer TOKEN" in the call's metadata, else by a client certificate. While no
/// identity was ever made and none is required, everyone is an admin. Thread-safe.
///
/// A call is allowed or refused when it begins; revoking a token does not end a running session.
class AccessControl {
 public:
  /// `identities` outlives it.
  AccessControl(IdentityStore& identities, bool require_identity);

  /// Who makes the call that takes `request`, which names the method, as each RPC has a request of
  /// its own. Unauthenticated says what is wrong with the proof, PermissionDenied which permission
  /// is missing; both are logged.
  absl::StatusOr<Principal> Authorize(const grpc::ServerContextBase& context,
                                      const google::protobuf::Descriptor* request) const;

  /// Everyone is let in at this moment.
  absl::StatusOr<bool> IsOpen() const;

 private:
  absl::StatusOr<Principal> Identify(const grpc::ServerContextBase& context) const;

  IdentityStore& identities_;
  const bool require_identity_;
  std::map<const google::protobuf::Descriptor*, MethodPermission> permissions_;
};

}  // namespace dcloc::server
