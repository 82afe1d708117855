#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "core/localizer/localizer.h"
#include "server/base/object_pool.h"

namespace dcloc::server {

/// Turns one vehicle's scans into poses. There are two implementations: core's method, and a stub
/// to measure the transport alone. Not thread-safe.
class ScanLocalizer {
 public:
  virtual ~ScanLocalizer() = default;

  /// As Localizer::Localize. `scan` is valid and of a radar of the rig.
  virtual absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener) = 0;

  /// As Localizer::TakeFix.
  virtual absl::StatusOr<FixUse> TakeFix(const PositionFix& fix) = 0;

  /// As Localizer::Snapshot and Localizer::Restore.
  virtual std::optional<LocalizerSnapshot> Snapshot() = 0;
  virtual absl::Status Restore(const LocalizerSnapshot& snapshot) = 0;

  /// As Localizer::has_pose.
  virtual bool has_pose() const = 0;
};

/// Makes a session's localizer, as Localizer::Create.
using ScanLocalizerFactory = std::function<absl::StatusOr<std::unique_ptr<ScanLocalizer>>(
    std::shared_ptr<const RadarMap> map, Rig rig, const std::optional<InitialPose>& initial_pose,
    const LocalizerOptions& options)>;

/// The memory that a scan needs while it is localized; the sessions of a server share the pool.
using WorkspacePool = ObjectPool<LocalizerWorkspace>;

/// The method: core's Localizer. `workspaces` outlives it. `methods` replace core's registration.
absl::StatusOr<std::unique_ptr<ScanLocalizer>> CreateCoreScanLocalizer(
    WorkspacePool& workspaces, std::shared_ptr<const RadarMap> map, Rig rig,
    const std::optional<InitialPose>& initial_pose, const LocalizerOptions& options,
    const RegistrationMethods& methods = {});

/// The stub. Integrates the ego-velocity that the client sends, from the initial pose or else the
/// identity, and ignores all targets and fixes. Its answers show this: the state is always
/// kDeadReckoning, the quality is zero, no degree of freedom is observed, no source is healthy,
/// every fix is contradicted, there is no snapshot, and the covariance is the initial pose's.
absl::StatusOr<std::unique_ptr<ScanLocalizer>> CreateStubScanLocalizer(
    std::shared_ptr<const RadarMap> map, Rig rig, const std::optional<InitialPose>& initial_pose,
    const LocalizerOptions& options);

}  // namespace dcloc::server
