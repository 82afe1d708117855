#pragma once

#include <cstdint>
#include <optional>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

/// The pose from a session's last answers, as the prior of a new session. Not thread-safe.
class Prior {
 public:
  void Note(const v1::LocalizationResult& result);

  /// Makes the last pose the initial one of `open`, its covariance widened by the way that the
  /// vehicle may have come until `stamp_ns`. Without any answer `open` stays as it is. If the last
  /// answer has no confirmed pose, the initialization is removed.
  void Apply(std::int64_t stamp_ns, v1::OpenSession* open) const;

 private:
  bool noted_ = false;
  std::optional<v1::LocalizationResult> last_;  ///< none when the newest has no pose
  double speed_mps_ = 0.0;                      ///< between the last two
};

}  // namespace dcloc::client
