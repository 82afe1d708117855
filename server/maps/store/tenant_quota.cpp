#include "server/maps/store/tenant_quota.h"

#include <algorithm>
#include <list>
#include <map>
#include <mutex>

#include "absl/strings/str_format.h"

namespace dcloc::server {

struct TenantQuota::Claims {
  /// Held while room is counted and taken, so that of two uploads one comes second.
  std::mutex mutex;
  std::list<StorageClaim> list;

  static Hold Add(const std::shared_ptr<Claims>& claims, const StorageClaim& claim) {
    claims->list.push_front(claim);
    return Hold([claims, entry = claims->list.begin()] {
      const std::lock_guard lock(claims->mutex);
      claims->list.erase(entry);
    });
  }
};

TenantQuota::TenantQuota(Catalogue& catalogue, const IncomingFiles& incoming)
    : catalogue_(catalogue), incoming_(incoming), claims_(std::make_shared<Claims>()) {}

absl::StatusOr<Hold> TenantQuota::Reserve(const StorageClaim& claim, std::int64_t max_bytes) {
  const std::lock_guard lock(claims_->mutex);
  const absl::StatusOr<std::int64_t> known = catalogue_.SizeOfFile(claim.prefix, claim.sha256);
  if (!known.ok()) return known.status();
  if (*known != 0 && *known != claim.size_bytes) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "header.size_bytes is %d; the file of that hash has %d bytes", claim.size_bytes, *known));
  }
  // A file that the tenant has already takes no more room.
  if (max_bytes == 0 || *known != 0) return Claims::Add(claims_, claim);
  // In this order: what becomes a version meanwhile counts twice rather than not at all.
  const absl::StatusOr<std::int64_t> pending = PendingBytes(claim);
  if (!pending.ok()) return pending.status();
  const absl::StatusOr<std::int64_t> used = catalogue_.SizeOfMaps(claim.prefix);
  if (!used.ok()) return used.status();
  if (*used + *pending + claim.size_bytes <= max_bytes) return Claims::Add(claims_, claim);
  return absl::ResourceExhaustedError(
      absl::StrFormat("the maps take %d bytes, unfinished uploads %d, and header.size_bytes is %d; "
                      "max_tenant_storage_mib is %d",
                      *used, *pending, claim.size_bytes, max_bytes >> 20));
}

absl::StatusOr<std::int64_t> TenantQuota::PendingBytes(const StorageClaim& claim) const {
  absl::StatusOr<std::map<std::string, std::int64_t>> sizes = incoming_.SizesOf(claim.tenant);
  if (!sizes.ok()) return sizes.status();
  for (const StorageClaim& other : claims_->list) {
    if (other.tenant != claim.tenant) continue;
    std::int64_t& size_bytes = (*sizes)[other.sha256];
    size_bytes = std::max(size_bytes, other.size_bytes);
  }
  sizes->erase(claim.sha256);
  std::int64_t sum_bytes = 0;
  for (const auto& [sha256, size_bytes] : *sizes) {
    const absl::StatusOr<std::int64_t> known = catalogue_.SizeOfFile(claim.prefix, sha256);
    if (!known.ok()) return known.status();
    if (*known == 0) sum_bytes += size_bytes;
  }
  return sum_bytes;
}

}  // namespace dcloc::server
