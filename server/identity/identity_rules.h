#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/identity/identity_store.h"

/// What every store of identities checks and says alike.
namespace dcloc::server {

/// InvalidArgument names what of a new principal is not well-formed.
absl::Status CheckPrincipal(const Principal& principal);

/// DataLoss names whose identity has a role that this program does not know.
absl::StatusOr<Role> RoleOfIdentity(std::int64_t id, absl::string_view principal_name,
                                    absl::string_view role_name);

/// The principal of an identity that is neither revoked nor expired; else Unauthenticated. `what`
/// names the proof.
absl::StatusOr<Principal> ValidPrincipal(const IdentityRecord& record, absl::string_view what,
                                         SystemTime now);

/// How the proofs are named in errors.
std::string ProofByToken();
std::string ProofByCertificate(absl::string_view common_name);

absl::Status ProofNotKnown(absl::string_view what);
absl::Status CertificateNameTaken(absl::string_view name);
absl::Status NoSuchIdentity(std::int64_t id);

}  // namespace dcloc::server
