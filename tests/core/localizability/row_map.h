#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/map/editable_map.h"

namespace dcloc {

/// A landmark on its own, in the map frame.
struct TestLandmark {
  double x_m = 0.0;
  double y_m = 0.0;
  double sigma_m = 0.05;  ///< of further returns
};

/// A map along the x axis, a keyframe each ten metres from 0 on, and these landmarks.
inline std::shared_ptr<const RadarMap> RowMap(std::size_t keyframe_count,
                                              const std::vector<TestLandmark>& landmarks) {
  EditableMap map;
  map.name = "row";
  map.info.index_cell_m = 50.0;
  map.info.length_m = 10.0 * static_cast<double>(keyframe_count - 1);
  for (std::size_t i = 0; i < keyframe_count; ++i) {
    EditableKeyframe keyframe;
    keyframe.record.translation_local_m = {10.0 * static_cast<double>(i), 0.0, 0.0};
    keyframe.record.rotation_wxyz = {1.0, 0.0, 0.0, 0.0};
    map.keyframes.push_back(keyframe);
  }
  for (const TestLandmark& landmark : landmarks) {
    const double nearest = std::round(landmark.x_m / 10.0);
    const auto index = static_cast<std::size_t>(
        std::min(std::max(nearest, 0.0), static_cast<double>(keyframe_count - 1)));
    MapPoint point{};
    point.x_m = static_cast<float>(landmark.x_m - 10.0 * static_cast<double>(index));
    point.y_m = static_cast<float>(landmark.y_m);
    point.xx_m2 = point.yy_m2 = static_cast<float>(landmark.sigma_m * landmark.sigma_m);
    point.zz_m2 = 1.0F;
    point.scan_count = 20;
    point.pass_count = 1;
    map.keyframes[index].points.push_back(point);
  }
  return RadarMap::FromBytes(ToMapBytes(map).value()).value();
}

/// Posts at either side whose distances follow no rule.
inline std::vector<TestLandmark> ScatteredPosts(double from_m, double to_m) {
  std::vector<TestLandmark> posts;
  double x_m = from_m;
  for (int i = 0; x_m < to_m; ++i) {
    posts.push_back({.x_m = x_m, .y_m = (i % 2 == 0 ? 6.0 : -6.0) + 2.5 * std::sin(5.7 * i)});
    x_m += 1.4 + 1.2 * std::sin(12.9 * i + 1.0);
  }
  return posts;
}

}  // namespace dcloc
