#include "server/identity/usage.h"

#include "absl/strings/str_format.h"
#include "server/base/status.h"

namespace dcloc::server {

SessionPermit::SessionPermit(const Limits& limits, std::shared_ptr<PrincipalUsage> usage)
    : limits_(limits), usage_(std::move(usage)) {
  ++usage_->session_count;
}

SessionPermit::~SessionPermit() { --usage_->session_count; }

absl::Status SessionPermit::ChargeScan(int target_count,
                                       std::chrono::steady_clock::time_point now) const {
  if (const int max = limits_.max_target_count; target_count > max) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("scan has %d targets; max_target_count is %d", target_count, max));
  }
  if (const int max = limits_.max_scan_rate_hz_per_principal; !usage_->scans.Take(max, now)) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("scans come faster than max_scan_rate_hz_per_principal, which is %d", max));
  }
  return absl::OkStatus();
}

absl::Status SessionPermit::ChargeFix(std::chrono::steady_clock::time_point now) const {
  if (const int max = limits_.max_scan_rate_hz_per_principal; !usage_->fixes.Take(max, now)) {
    return absl::ResourceExhaustedError(absl::StrFormat(
        "position fixes come faster than max_scan_rate_hz_per_principal, which is %d", max));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const SessionPermit>> UsageCounts::TakeSession(
    const Principal& principal) {
  const std::lock_guard lock(mutex_);
  std::erase_if(usages_, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<PrincipalUsage>& entry = usages_[{principal.tenant, principal.name}];
  std::shared_ptr<PrincipalUsage> usage = entry.lock();
  if (usage == nullptr) entry = usage = std::make_shared<PrincipalUsage>();
  const int max = limits_.max_session_count_per_principal;
  if (max > 0 && usage->session_count >= max) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("%s has %d open sessions; max_session_count_per_principal is %d",
                        Quoted(principal.name), usage->session_count.load(), max));
  }
  return std::make_shared<const SessionPermit>(limits_, std::move(usage));
}

}  // namespace dcloc::server
