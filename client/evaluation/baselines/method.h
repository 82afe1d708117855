#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "core/localizer/localizer.h"

namespace dcloc {

/// A way of localizing one vehicle in one map, scan by scan.
class Method {
 public:
  virtual ~Method() = default;

  /// As `Localizer::Localize`. An answer whose method knows no covariance observes no degree of
  /// freedom.
  virtual absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener) = 0;
};

/// What is compared; README.md says what each one takes from where.
enum class MethodKind {
  kIcp,
  kNdt,
  kMcRansac,
  kDcLoc,
  kDcLocPlusPlus,
  kDcloc,
  // Others' registration inside our localizer, through its seam.
  kDclocIcp,
  kDclocGicp,
  kDclocNdt,
  kDclocDescriptor,
};

/// By the names that users write.
inline constexpr std::array<std::pair<const char*, MethodKind>, 10> kMethodNames = {
    {{"icp", MethodKind::kIcp},
     {"ndt", MethodKind::kNdt},
     {"mc-ransac", MethodKind::kMcRansac},
     {"dc-loc", MethodKind::kDcLoc},
     {"dc-loc++", MethodKind::kDcLocPlusPlus},
     {"dcloc", MethodKind::kDcloc},
     {"dcloc+icp", MethodKind::kDclocIcp},
     {"dcloc+gicp", MethodKind::kDclocGicp},
     {"dcloc+ndt", MethodKind::kDclocNdt},
     {"dcloc+descriptor", MethodKind::kDclocDescriptor}}};

/// The method's name in `kMethodNames`.
std::string MethodName(MethodKind kind);

/// Whether the method is our localizer, with our registration or another one.
bool RunsInLocalizer(MethodKind kind);

/// A method at the start of a session. All take the same options, as far as they have the part in
/// question. InvalidArgument for an invalid rig, pose or options, and without an initial pose for
/// the methods that cannot search the whole map: those that do not run in the localizer.
absl::StatusOr<std::unique_ptr<Method>> CreateMethod(MethodKind kind,
                                                     const std::shared_ptr<const RadarMap>& map,
                                                     const Rig& rig,
                                                     const std::optional<InitialPose>& initial_pose,
                                                     const LocalizerOptions& options);

}  // namespace dcloc
