#include "server/objects/object_error.h"

#include "absl/strings/cord.h"
#include "absl/types/optional.h"

namespace dcloc::server {
namespace {

constexpr char kReasonUrl[] = "dcloc/object-store-away";

}  // namespace

absl::Status ObjectStoreError(absl::string_view reason) {
  absl::Status status = absl::UnavailableError(kObjectStoreIsAway);
  status.SetPayload(kReasonUrl, absl::Cord(reason));
  return status;
}

bool IsObjectStoreError(const absl::Status& status) {
  return status.GetPayload(kReasonUrl).has_value();
}

std::string ObjectStoreReason(const absl::Status& status) {
  const absl::optional<absl::Cord> reason = status.GetPayload(kReasonUrl);
  return reason ? std::string(*reason) : std::string(status.message());
}

}  // namespace dcloc::server
