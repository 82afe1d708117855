#include "core/online_calibration/drive_stamps.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace dcloc {
namespace {

// Of a whole drive no moment is older than another.
RadarDelayOptions WithoutForgetting(RadarDelayOptions options) {
  options.time_constant = std::chrono::hours(24);
  options.update_interval = std::chrono::seconds(4);
  return options;
}

}  // namespace

DriveStamps::DriveStamps(Rig described, const LearnedStampOptions& options)
    : options_(options),
      described_(std::make_shared<const Rig>(std::move(described))),
      delays_(*described_, WithoutForgetting(options.delays)) {}

bool DriveStamps::IsNeeded() const {
  return std::ranges::all_of(
      described_->radars, [](const RadarModel& radar) { return radar.time_offset_sigma_s > 0.0; });
}

void DriveStamps::Add(const Scan& scan) {
  const std::size_t index = described_->IndexOf(scan.radar_id);
  ego_motion_.Advance(scan, scan.stamp, described_->radars[index], workspace_);
  delays_.OnScan(scan.stamp, index, scan, ego_motion_.sources().AllSound());
}

void DriveStamps::BeginPass() {
  ego_motion_ = EgoMotion();
  delays_.OnDiscontinuity();
}

MeasuredStamps DriveStamps::Measured() {
  delays_.Update();
  return ToMeasuredStamps(delays_, options_);
}

}  // namespace dcloc
