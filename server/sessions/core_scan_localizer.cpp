#include <utility>

#include "server/sessions/scan_localizer.h"

namespace dcloc::server {
namespace {

class CoreScanLocalizer final : public ScanLocalizer {
 public:
  explicit CoreScanLocalizer(Localizer localizer) : localizer_(std::move(localizer)) {}

  absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener) override {
    return localizer_.Localize(scan, listener);
  }

  bool searching() const override { return localizer_.searching(); }

 private:
  Localizer localizer_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<ScanLocalizer>> CreateCoreScanLocalizer(
    std::shared_ptr<const RadarMap> map, Rig rig, const std::optional<InitialPose>& initial_pose,
    const LocalizerOptions& options) {
  absl::StatusOr<Localizer> localizer =
      Localizer::Create(std::move(map), std::move(rig), initial_pose, options);
  if (!localizer.ok()) return localizer.status();
  return std::make_unique<CoreScanLocalizer>(*std::move(localizer));
}

}  // namespace dcloc::server
