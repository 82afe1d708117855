#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/map/keyframe_index.h"
#include "core/map/map_file.h"

namespace dcloc {

/// The parts of a made-up map: keyframes every 10 m on a spiral whose turns lie 200 m apart, so
/// that it fills an area as streets do, each with `points_per_keyframe` points.
struct SyntheticMap {
  InfoRecord info{};
  std::string name = "spiral";
  std::string description = "made up";
  std::vector<KeyframeRecord> keyframes;
  std::vector<IndexRecord> index;
  std::vector<MapPoint> points;

  SyntheticMap(std::size_t keyframe_count, std::uint32_t points_per_keyframe,
               bool with_points = true) {
    double angle_rad = 2.0 * M_PI;
    for (std::size_t i = 0; i < keyframe_count; ++i) {
      const double radius_m = 200.0 * angle_rad / (2.0 * M_PI);
      const double heading_rad = angle_rad + M_PI / 2.0;
      keyframes.push_back(
          {.translation_local_m = {radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad),
                                   1.5},
           .rotation_wxyz = {std::cos(heading_rad / 2.0), 0.0, 0.0, std::sin(heading_rad / 2.0)},
           .first_point = i * points_per_keyframe,
           .point_count = points_per_keyframe,
           .accuracy = 0});
      angle_rad += 10.0 / radius_m;
    }
    info.local_origin_m = {500'000.0, 5'400'000.0, 100.0};
    info.length_m = 10.0 * static_cast<double>(keyframe_count);
    info.index_cell_m = 32.0;
    info.name_size_bytes = static_cast<std::uint32_t>(name.size());
    index = MakeIndex(keyframes, info.index_cell_m);
    if (!with_points) return;
    for (std::size_t i = 0; i < keyframe_count * points_per_keyframe; ++i) {
      const auto step = static_cast<float>(i % 50);
      points.push_back({.x_m = step - 25.0F,
                        .y_m = 5.0F + 0.1F * step,
                        .z_m = 0.5F,
                        .xx_m2 = 0.04F,
                        .xy_m2 = 0.01F,
                        .xz_m2 = 0.0F,
                        .yy_m2 = 0.09F,
                        .yz_m2 = 0.0F,
                        .zz_m2 = 1.0F,
                        .rcs_dbsm = 3.0F,
                        .scan_count = 7,
                        .pass_count = 1});
    }
  }

  MapFileView View() const { return {info, name, description, keyframes, index, points}; }
  std::vector<std::byte> Bytes() const { return WriteMapFile(View()); }
};

}  // namespace dcloc
