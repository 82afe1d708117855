#include "server/identity/identity_rules.h"

#include <optional>

#include "absl/strings/str_cat.h"
#include "server/base/check.h"
#include "server/base/status.h"

namespace dcloc::server {

absl::Status CheckPrincipal(const Principal& principal) {
  absl::Status status = CheckId("name", principal.name);
  if (!principal.tenant.empty()) status.Update(CheckMapName("tenant", principal.tenant));
  return status;
}

absl::StatusOr<Role> RoleOfIdentity(std::int64_t id, absl::string_view principal_name,
                                    absl::string_view role_name) {
  const std::optional<Role> role = RoleFromName(role_name);
  if (role) return *role;
  return absl::DataLossError(absl::StrCat("identity ", id, ": role of ", Quoted(principal_name),
                                          " is ", Quoted(role_name),
                                          "; it must be vehicle, viewer, operator or admin"));
}

absl::StatusOr<Principal> ValidPrincipal(const IdentityRecord& record, absl::string_view what,
                                         SystemTime now) {
  if (record.revoke_time) return absl::UnauthenticatedError(absl::StrCat(what, " was revoked"));
  if (record.expire_time && *record.expire_time <= now) {
    return absl::UnauthenticatedError(absl::StrCat(what, " has expired"));
  }
  return record.principal;
}

std::string ProofByToken() { return "the token"; }

std::string ProofByCertificate(absl::string_view common_name) {
  return absl::StrCat("the certificate of ", Quoted(common_name));
}

absl::Status ProofNotKnown(absl::string_view what) {
  return absl::UnauthenticatedError(absl::StrCat(what, " is not known"));
}

absl::Status CertificateNameTaken(absl::string_view name) {
  return absl::AlreadyExistsError(
      absl::StrCat("name is ", Quoted(name), "; a certificate of that name is known already"));
}

absl::Status NoSuchIdentity(std::int64_t id) {
  return absl::NotFoundError(absl::StrCat("id is ", id, "; there is no such identity"));
}

}  // namespace dcloc::server
