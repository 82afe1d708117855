#include "server/admin/identity_calls.h"

#include <string>
#include <vector>

#include "server/convert/page.h"
#include "server/convert/time.h"

namespace dcloc::server {
namespace {

v1::IdentityProof ToProto(Proof proof) {
  return proof == Proof::kToken ? v1::IDENTITY_PROOF_TOKEN : v1::IDENTITY_PROOF_CERTIFICATE;
}

void Describe(const IdentityRecord& record, v1::Identity* identity) {
  identity->set_id(record.id);
  identity->set_proof(ToProto(record.proof));
  identity->set_name(record.principal.name);
  identity->set_tenant(record.principal.tenant);
  identity->set_role(std::string(NameOf(record.principal.role)));
  *identity->mutable_create_time() = convert::ToProto(record.create_time);
  if (record.expire_time) *identity->mutable_expire_time() = convert::ToProto(*record.expire_time);
  if (record.revoke_time) *identity->mutable_revoke_time() = convert::ToProto(*record.revoke_time);
}

}  // namespace

absl::Status ListIdentities(IdentityStore& identities, const v1::ListIdentitiesRequest& request,
                            v1::ListIdentitiesResponse* response) {
  const absl::StatusOr<int> size = convert::PageSizeFromProto(request.page_size());
  if (!size.ok()) return size.status();
  const absl::StatusOr<std::int64_t> after =
      convert::NumberFromPageToken(request.page_token(), /*first=*/0);
  if (!after.ok()) return after.status();
  // One more, which says whether there is a next page.
  const absl::StatusOr<std::vector<IdentityRecord>> records = identities.List(*after, *size + 1);
  if (!records.ok()) return records.status();
  for (const IdentityRecord& record : *records) {
    if (response->identities_size() == *size) {
      response->set_next_page_token(std::to_string(response->identities(*size - 1).id()));
      break;
    }
    Describe(record, response->add_identities());
  }
  return absl::OkStatus();
}

}  // namespace dcloc::server
