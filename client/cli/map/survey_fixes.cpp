#include "client/cli/map/survey_fixes.h"

#include <cstddef>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client/datasets/fix_file.h"

namespace dcloc::cli {
namespace {

std::optional<std::size_t> DriveAt(std::span<const DriveTrack> tracks, Stamp stamp) {
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const std::vector<TrackedScan>& scans = tracks[i].scans;
    if (!scans.empty() && stamp >= scans.front().stamp && stamp <= scans.back().stamp) return i;
  }
  return std::nullopt;
}

SurveyFix ToSurveyFix(const StampedFix& fix, std::size_t drive,
                      std::optional<GeodeticAnchor>& anchor) {
  if (const auto* in_map = std::get_if<MapFix>(&fix.position)) {
    return {drive, fix.stamp, in_map->p_map.head<2>(), in_map->horizontal_sigma_m};
  }
  const GnssFix& gnss = std::get<GnssFix>(fix.position);
  if (!anchor) anchor = GeodeticAnchor{.origin = gnss.position};
  return {drive, fix.stamp, MapFromGeodetic(*anchor, gnss.position).head<2>(),
          gnss.horizontal_sigma_m};
}

}  // namespace

absl::StatusOr<SurveyFixes> ReadSurveyFixes(std::span<const std::string> paths,
                                            std::span<const DriveTrack> tracks,
                                            std::optional<GeodeticAnchor> anchor) {
  SurveyFixes result{.fixes = {}, .anchor = anchor};
  std::optional<std::size_t> kind;  // of all positions
  for (const std::string& path : paths) {
    const auto fixes = ReadFixes(path);
    if (!fixes.ok()) return fixes.status();
    const std::size_t count_before = result.fixes.size();
    for (const StampedFix& fix : *fixes) {
      if (kind.value_or(fix.position.index()) != fix.position.index()) {
        return absl::InvalidArgumentError(absl::StrCat(
            path,
            ": its fixes are in another frame than those before; all must be on the Earth, "
            "or all in one map frame"));
      }
      kind = fix.position.index();
      const std::optional<std::size_t> drive = DriveAt(tracks, fix.stamp);
      if (drive) result.fixes.push_back(ToSurveyFix(fix, *drive, result.anchor));
    }
    if (result.fixes.size() == count_before) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": none of its ", fixes->size(),
                       " fixes has a stamp within a drive; are clocks the same?"));
    }
  }
  return result;
}

}  // namespace dcloc::cli
