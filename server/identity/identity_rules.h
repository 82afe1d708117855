#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
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

/// Reads id, proof, name, tenant, role and the times of creation, expiry and revocation, in this
/// order, from a row of any database. `IsCertificate` takes the proof.
template <typename Row, typename IsCertificate>
absl::StatusOr<IdentityRecord> ReadIdentity(Row& row, const IsCertificate& is_certificate) {
  const auto next_time = [&row]() -> std::optional<SystemTime> {
    const bool present = !row.NextIsNull();
    const std::chrono::nanoseconds time(row.NextInteger());
    return present ? std::optional(SystemTime(time)) : std::nullopt;
  };
  IdentityRecord record;
  record.id = row.NextInteger();
  record.proof = is_certificate(row) ? Proof::kCertificate : Proof::kToken;
  record.principal.name = row.NextText();
  record.principal.tenant = row.NextText();
  const absl::StatusOr<Role> role =
      RoleOfIdentity(record.id, record.principal.name, row.NextText());
  if (!role.ok()) return role.status();
  record.principal.role = *role;
  record.create_time = SystemTime(std::chrono::nanoseconds(row.NextInteger()));
  record.expire_time = next_time();
  record.revoke_time = next_time();
  return record;
}

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
