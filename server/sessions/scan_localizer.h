#pragma once

#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "core/localizer/localizer.h"

namespace dcloc::server {

/// What turns one vehicle's scans into poses. The server has two: the method, and one that does not
/// match, with which the transport alone can be measured. Not thread-safe.
class Matcher {
 public:
  virtual ~Matcher() = default;

  /// As Localizer::Localize. `scan` is valid and of a radar of the rig.
  virtual absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener) = 0;

  /// As Localizer::searching.
  virtual bool searching() const = 0;
};

/// As Localizer::Create.
using MatcherFactory = absl::StatusOr<std::unique_ptr<Matcher>>(
    std::shared_ptr<const RadarMap> map, Rig rig, const std::optional<InitialPose>& initial_pose,
    const LocalizerOptions& options);

/// The method: core's Localizer.
MatcherFactory CreateLocalizerMatcher;

/// Integrates the ego-velocity that the client sends from the initial pose, the identity without
/// one, and never looks at a target. It says so: its state is always kDeadReckoning, its quality
/// zero, no degree of freedom is observed, and the covariance is the initial pose's.
MatcherFactory CreateStubMatcher;

}  // namespace dcloc::server
