#include "server/identity/access_control.h"

#include <grpc/grpc_security_constants.h>

#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr char kMetadataKey[] = "authorization";
constexpr char kScheme[] = "Bearer ";
constexpr char kTenantKey[] = "dcloc-tenant";

absl::string_view ViewOf(const grpc::string_ref& text) { return {text.data(), text.size()}; }

/// The peer's verified common name; empty without a client certificate.
std::string CommonNameOf(const grpc::ServerContextBase& context) {
  const std::shared_ptr<const grpc::AuthContext> peer = context.auth_context();
  if (peer == nullptr || !peer->IsPeerAuthenticated()) return "";
  const std::vector<grpc::string_ref> names = peer->FindPropertyValues(GRPC_X509_CN_PROPERTY_NAME);
  return names.empty() ? "" : std::string(ViewOf(names.front()));
}

absl::Status CheckPermission(const Principal& principal, const MethodPermission& needed) {
  if (Grants(principal.role, principal.tenant, needed.permission)) return absl::OkStatus();
  return absl::PermissionDeniedError(absl::StrCat(
      needed.method, " needs the permission ", NameOf(needed.permission), ", which ",
      Quoted(principal.name), " as ", NameOf(principal.role),
      principal.tenant.empty() ? "" : absl::StrCat(" of tenant ", Quoted(principal.tenant)),
      " does not have"));
}

/// Puts the caller into the tenant that the call names, if it names one.
absl::Status EnterTenant(const grpc::ServerContextBase& context, Principal* principal) {
  const auto named = context.client_metadata().find(kTenantKey);
  if (named == context.client_metadata().end()) return absl::OkStatus();
  const std::string tenant(ViewOf(named->second));
  if (tenant == principal->tenant) return absl::OkStatus();
  if (!Grants(principal->role, principal->tenant, Permission::kManageServer)) {
    return absl::PermissionDeniedError(absl::StrCat(
        kTenantKey, " of another tenant needs the permission ", NameOf(Permission::kManageServer)));
  }
  if (absl::Status status = CheckMapName(kTenantKey, tenant); !status.ok()) return status;
  principal->tenant = tenant;
  return absl::OkStatus();
}

}  // namespace

AccessControl::AccessControl(IdentityStore& identities, bool require_identity)
    : identities_(identities), require_identity_(require_identity) {
  const google::protobuf::DescriptorPool& pool =
      *google::protobuf::DescriptorPool::generated_pool();
  for (const MethodPermission& entry : MethodPermissions()) {
    const google::protobuf::MethodDescriptor* method = pool.FindMethodByName(entry.method);
    if (method != nullptr) permissions_.emplace(method->input_type(), entry);
  }
}

absl::StatusOr<Principal> AccessControl::Authorize(
    const grpc::ServerContextBase& context, const google::protobuf::Descriptor* request) const {
  const auto needed = permissions_.find(request);
  absl::StatusOr<Principal> principal = Identify(context);
  absl::Status status = principal.status();
  if (needed == permissions_.end()) {
    status = absl::PermissionDeniedError(
        absl::StrCat(request->full_name(), " belongs to no method with a known permission"));
  } else if (status.ok()) {
    status = CheckPermission(*principal, needed->second);
  }
  if (status.ok()) status = EnterTenant(context, &*principal);
  if (status.ok()) return principal;
  spdlog::warn("denied request={} peer={} reason=\"{}\"", request->full_name(), context.peer(),
               absl::CHexEscape(status.message()));
  return status;
}

absl::StatusOr<bool> AccessControl::IsOpen() const {
  if (needs_proof()) return false;
  const absl::StatusOr<bool> any = identities_.HasAny();
  if (!any.ok()) return any.status();
  if (*any) has_identities_ = true;
  return !*any;
}

absl::StatusOr<Principal> AccessControl::Identify(const grpc::ServerContextBase& context) const {
  const std::string common_name = CommonNameOf(context);
  const absl::StatusOr<bool> open = IsOpen();
  if (!open.ok()) return open.status();
  if (*open) return Principal{.name = common_name.empty() ? "anonymous" : common_name};
  const auto metadata = context.client_metadata().find(kMetadataKey);
  if (metadata != context.client_metadata().end()) {
    const absl::string_view value = ViewOf(metadata->second);
    if (!absl::StartsWith(value, kScheme)) {
      return absl::UnauthenticatedError("authorization is not of the form \"Bearer TOKEN\"");
    }
    return identities_.FindToken(value.substr(sizeof(kScheme) - 1));
  }
  if (!common_name.empty()) return identities_.FindCertificate(common_name);
  return absl::UnauthenticatedError(
      "no identity: send \"authorization: Bearer TOKEN\" or a client certificate");
}

}  // namespace dcloc::server
