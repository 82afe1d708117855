#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/localizer/position_fix.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::server {

/// What became of one position fix, as a plain struct.
struct FixAnswer {
  std::int64_t stamp_ns = 0;   ///< the fix's, as it was sent
  absl::StatusOr<FixUse> use;  ///< or why it was not looked at
};

namespace convert {

/// In a map with that anchor, if any. InvalidArgument names the field, the value and the bound;
/// FailedPrecondition for a GNSS fix in a map without an anchor.
absl::StatusOr<PositionFix> FromProto(const v1::PositionFix& message,
                                      const std::optional<GeodeticAnchor>& anchor);

/// Sets every field, so that nothing of what `message` held before shows through.
void ToProto(const FixAnswer& answer, v1::PositionFixAnswer* message);

}  // namespace convert
}  // namespace dcloc::server
