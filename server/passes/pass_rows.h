#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/clock.h"

namespace dcloc::server {

/// A pass that is kept.
struct PassRow {
  std::int64_t number = 0;  ///< rises with each pass
  std::string pass_id;      ///< names its file
  std::string tenant;
  std::string map_name;  ///< without the tenant
  std::int64_t map_version = 0;
  std::string vehicle;   ///< pseudonym
  std::string identity;  ///< pseudonym of the identity whose consent it was kept by
  std::int64_t scan_count = 0;
  std::int64_t size_bytes = 0;
  std::int64_t first_stamp_ns = 0;
  std::int64_t last_stamp_ns = 0;
  std::string sha256;  ///< of its file
  SystemTime create_time;
  SystemTime expire_time;
};

/// What a consent is about.
enum class ConsentSubject { kMap, kIdentity };

struct ConsentRow {
  ConsentSubject subject = ConsentSubject::kMap;
  std::string name;
};

/// Bounds on what is kept.
struct PassQuota {
  std::int64_t max_tenant_bytes = 0;
  std::int64_t max_vehicle_bytes_per_day = 0;  ///< of the 24 hours before
};

/// The consents to keep passes, and the passes that are kept. Several servers may share them if the
/// implementation says so. Thread-safe; calls may block on storage, with the errors of `Catalogue`.
class PassRows {
 public:
  virtual ~PassRows() = default;

  virtual absl::Status GiveConsent(absl::string_view tenant, const ConsentRow& consent) = 0;

  /// Removes the consent, and the passes that were kept under it: of the map, or of the identity
  /// with that pseudonym. Gives their ids.
  virtual absl::StatusOr<std::vector<std::string>> WithdrawConsent(absl::string_view tenant,
                                                                   const ConsentRow& consent,
                                                                   absl::string_view pseudonym) = 0;

  /// Whether both consent.
  virtual absl::StatusOr<bool> MayKeep(absl::string_view tenant, absl::string_view map_name,
                                       absl::string_view identity_name) = 0;

  /// At most `limit` from `offset` on; maps first, by name.
  virtual absl::StatusOr<std::vector<ConsentRow>> ListConsents(absl::string_view tenant,
                                                               std::int64_t offset, int limit) = 0;

  /// `identity_name` is whose consent it is. PermissionDenied: one of the two does not consent any
  /// more. ResourceExhausted names the bound that would be passed.
  virtual absl::Status Add(const PassRow& row, absl::string_view identity_name,
                           const PassQuota& quota) = 0;

  /// At most `limit` passes over a map with numbers below `below`, newest first.
  virtual absl::StatusOr<std::vector<PassRow>> List(absl::string_view tenant,
                                                    absl::string_view map_name, std::int64_t below,
                                                    int limit) = 0;

  /// Removes passes whose time is over; gives their ids.
  virtual absl::StatusOr<std::vector<std::string>> RemoveExpired(SystemTime now) = 0;

  /// Of all passes.
  virtual absl::StatusOr<std::vector<std::string>> ListIds() = 0;

  /// Bytes of all passes, for gauges.
  virtual absl::StatusOr<std::int64_t> TotalBytes() = 0;
};

/// What implementations say alike.
absl::Status NoConsent();
absl::Status CheckQuota(std::int64_t size_bytes, std::int64_t tenant_bytes,
                        std::int64_t vehicle_bytes, const PassQuota& quota);

}  // namespace dcloc::server
