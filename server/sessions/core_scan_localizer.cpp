#include <utility>

#include "core/localizer/workspace.h"
#include "server/sessions/scan_localizer.h"

namespace dcloc::server {
namespace {

class CoreScanLocalizer final : public ScanLocalizer {
 public:
  CoreScanLocalizer(WorkspacePool& workspaces, Localizer localizer)
      : workspaces_(workspaces), localizer_(std::move(localizer)) {}

  absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener) override {
    const WorkspacePool::Lease workspace = workspaces_.Acquire();
    return localizer_.Localize(scan, *workspace, listener);
  }

  absl::StatusOr<FixUse> TakeFix(const PositionFix& fix) override {
    return localizer_.TakeFix(fix);
  }

  std::optional<LocalizerSnapshot> Snapshot() override { return localizer_.Snapshot(); }

  absl::Status Restore(const LocalizerSnapshot& snapshot) override {
    return localizer_.Restore(snapshot);
  }

  bool has_pose() const override { return localizer_.has_pose(); }

 private:
  WorkspacePool& workspaces_;
  Localizer localizer_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<ScanLocalizer>> CreateCoreScanLocalizer(
    WorkspacePool& workspaces, std::shared_ptr<const RadarMap> map, Rig rig,
    const std::optional<InitialPose>& initial_pose, const LocalizerOptions& options,
    const RegistrationMethods& methods) {
  absl::StatusOr<Localizer> localizer =
      Localizer::Create(std::move(map), std::move(rig), initial_pose, options, methods);
  if (!localizer.ok()) return localizer.status();
  return std::make_unique<CoreScanLocalizer>(workspaces, *std::move(localizer));
}

}  // namespace dcloc::server
