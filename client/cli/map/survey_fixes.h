#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/mapping/survey.h"

namespace dcloc::cli {

/// Fixes of the drives, and where their frame lies on the Earth, if it does.
struct SurveyFixes {
  std::vector<SurveyFix> fixes;
  std::optional<GeodeticAnchor> anchor;
};

/// Reads fix files (ReadFixes); a fix belongs to the drive whose scans its stamp lies between.
/// Fixes on the Earth are brought into the frame of `anchor`, or of one at the first fix whose x
/// axis points east. Errors name the file: those of ReadFixes; InvalidArgument where none of its
/// fixes belongs to a drive, and where some fixes are on the Earth and others are not.
absl::StatusOr<SurveyFixes> ReadSurveyFixes(std::span<const std::string> paths,
                                            std::span<const DriveTrack> tracks,
                                            std::optional<GeodeticAnchor> anchor);

}  // namespace dcloc::cli
