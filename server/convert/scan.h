#pragma once

#include <cstdint>

#include "absl/strings/string_view.h"

#include "absl/status/statusor.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "dcloc/v1/scan.pb.h"

namespace dcloc::server::convert {

/// A valid rig; absent fields of a radar take core's defaults.
absl::StatusOr<Rig> FromProto(const v1::Rig& message, absl::string_view field);

/// OK for nanoseconds since the Unix epoch, after it and before the year 2100.
absl::Status CheckStamp(absl::string_view field, std::int64_t stamp_ns);

/// Fills `scan`. If OK is returned, it is valid and its radar is one of `rig`. Its columns' memory
/// is reused, so that a session's scans need no allocation once the columns have reached their
/// size.
absl::Status FromProto(const v1::Scan& message, const Rig& rig, Scan* scan);

}  // namespace dcloc::server::convert
