#include "client/trajectory/trajectory_format.h"

#include <string>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace dcloc {
namespace {

std::string Names() {
  std::vector<std::string> names;
  for (const auto& [name, format] : kTrajectoryFormatNames) names.emplace_back(name);
  return absl::StrJoin(names, ", ");
}

}  // namespace

absl::StatusOr<TrajectoryFormat> TrajectoryFormatOf(const std::filesystem::path& path,
                                                    absl::string_view name) {
  const std::string extension = absl::AsciiStrToLower(path.extension().string());
  std::string wanted(name);
  if (wanted.empty() && !extension.empty()) wanted = extension.substr(1);
  if (wanted == "json") wanted = "geojson";
  for (const auto& [known, format] : kTrajectoryFormatNames) {
    if (wanted == known) return format;
  }
  if (!name.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("trajectory format is '", name, "'; it must be one of ", Names()));
  }
  return absl::InvalidArgumentError(
      absl::StrCat(path.string(), ": its extension tells no trajectory format; name one of ",
                   Names(), ", or end the file's name with it"));
}

bool NeedsAnchor(TrajectoryFormat format) {
  return format == TrajectoryFormat::kGeoJson || format == TrajectoryFormat::kGpx;
}

}  // namespace dcloc
