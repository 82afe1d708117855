#include "client/cli/map/map_report.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/terminal.h"

namespace dcloc::cli {

using nlohmann::ordered_json;

ordered_json MapInfoJson(const MapInfo& info) {
  ordered_json json = {{"name", info.name},
                       {"description", info.description},
                       {"keyframe_count", info.keyframe_count},
                       {"point_count", info.point_count},
                       {"size_bytes", info.size_bytes},
                       {"length_m", info.length_m},
                       {"min_map_m", {info.min_map_m.x(), info.min_map_m.y(), info.min_map_m.z()}},
                       {"max_map_m", {info.max_map_m.x(), info.max_map_m.y(), info.max_map_m.z()}},
                       {"has_elevation", info.has_elevation},
                       {"stamp_delay_s", nullptr},
                       {"anchor", nullptr}};
  if (info.stamp_delay_s.has_value()) json["stamp_delay_s"] = *info.stamp_delay_s;
  if (info.anchor.has_value()) {
    json["anchor"] = {{"latitude_deg", info.anchor->origin.latitude_deg},
                      {"longitude_deg", info.anchor->origin.longitude_deg},
                      {"height_m", info.anchor->origin.height_m},
                      {"x_axis_east_rad", info.anchor->x_axis_east_rad}};
  }
  return json;
}

std::string MapInfoText(const MapInfo& info) {
  const auto extent = [](const Eigen::Vector3d& p) {
    return absl::StrFormat("(%.1f, %.1f, %.1f)", p.x(), p.y(), p.z());
  };
  std::string text = absl::StrFormat(
      "name         %s\n"
      "description  %s\n"
      "landmarks    %d%s\n"
      "keyframes    %d over %.0f m of street\n"
      "extent [m]   %s to %s\n"
      "size         %s\n",
      Visible(info.name), Visible(info.description), info.point_count,
      info.has_elevation ? ", measured in three dimensions" : "", info.keyframe_count,
      info.length_m, extent(info.min_map_m), extent(info.max_map_m),
      FormatBytes(static_cast<double>(info.size_bytes)));
  if (info.stamp_delay_s.has_value()) {
    absl::StrAppendFormat(&text, "stamps       of its radars are known, and were %.3f s late\n",
                          *info.stamp_delay_s);
  }
  if (info.anchor.has_value()) {
    absl::StrAppendFormat(&text, "anchor       %.7f, %.7f, %.2f m; x axis %.4f rad from east\n",
                          info.anchor->origin.latitude_deg, info.anchor->origin.longitude_deg,
                          info.anchor->origin.height_m, info.anchor->x_axis_east_rad);
  }
  return text;
}

}  // namespace dcloc::cli
