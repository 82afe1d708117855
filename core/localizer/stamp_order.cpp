#include "core/localizer/stamp_order.h"

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

double Nanoseconds(Stamp stamp) { return static_cast<double>(stamp.time_since_epoch().count()); }

}  // namespace

absl::Status StampOrder::Check(const Scan& scan) const {
  const auto of_radar = newest_of_radar_.find(scan.radar_id);
  if (of_radar != newest_of_radar_.end() && scan.stamp <= of_radar->second) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "stamp is %.0f ns; radar '%s' was at %.0f ns already, and its stamps must rise",
        Nanoseconds(scan.stamp), scan.radar_id, Nanoseconds(of_radar->second)));
  }
  if (newest_ && scan.stamp < *newest_) {
    return absl::InvalidArgumentError(
        absl::StrFormat("stamp is %.0f ns; it must not lie before the newest scan's %.0f ns",
                        Nanoseconds(scan.stamp), Nanoseconds(*newest_)));
  }
  return absl::OkStatus();
}

}  // namespace dcloc
