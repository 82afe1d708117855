#include <chrono>
#include <utility>

#include "absl/strings/str_format.h"
#include "server/sessions/scan_localizer.h"

namespace dcloc::server {
namespace {

class StubScanLocalizer final : public ScanLocalizer {
 public:
  StubScanLocalizer(std::shared_ptr<const RadarMap> map, std::size_t radar_count, InitialPose pose)
      : map_(std::move(map)), radar_count_(radar_count), pose_(std::move(pose)) {}

  absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* /*listener*/) override {
    if (last_stamp_ && scan.stamp < *last_stamp_) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "stamp_ns is %d; it must not lie before %d, the newest scan's",
          scan.stamp.time_since_epoch().count(), last_stamp_->time_since_epoch().count()));
    }
    if (last_stamp_ && scan.ego_velocity) {
      const double duration_s = std::chrono::duration<double>(scan.stamp - *last_stamp_).count();
      Vector6d motion;
      motion << scan.ego_velocity->linear_mps, scan.ego_velocity->angular_radps;
      pose_.T_map_vehicle = pose_.T_map_vehicle * Exp(Vector6d(motion * duration_s));
    }
    last_stamp_ = scan.stamp;
    Localization localization{.stamp = scan.stamp,
                              .state = LocalizationState::kDeadReckoning,
                              .T_map_vehicle = pose_.T_map_vehicle,
                              .covariance = pose_.covariance};
    localization.health.radars.resize(radar_count_);
    return localization;
  }

  absl::StatusOr<FixUse> TakeFix(const PositionFix& /*fix*/) override {
    return FixUse::kContradicted;
  }

  std::optional<LocalizerSnapshot> Snapshot() override { return std::nullopt; }
  absl::Status Restore(const LocalizerSnapshot& /*snapshot*/) override {
    return absl::UnimplementedError("the stub goes on from nothing");
  }

  bool has_pose() const override { return true; }

 private:
  std::shared_ptr<const RadarMap> map_;  // in use, as with the method
  const std::size_t radar_count_;
  InitialPose pose_;
  std::optional<Stamp> last_stamp_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<ScanLocalizer>> CreateStubScanLocalizer(
    // A ScanLocalizerFactory.  NOLINTNEXTLINE(performance-unnecessary-value-param)
    std::shared_ptr<const RadarMap> map, Rig rig, const std::optional<InitialPose>& initial_pose,
    const LocalizerOptions& /*options*/) {
  const InitialPose unknown{.T_map_vehicle = {}, .covariance = Matrix6d::Zero()};
  return std::make_unique<StubScanLocalizer>(std::move(map), rig.radars.size(),
                                             initial_pose.value_or(unknown));
}

}  // namespace dcloc::server
