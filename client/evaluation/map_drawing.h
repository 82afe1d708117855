#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <string>

#include "absl/strings/string_view.h"

namespace dcloc {

/// A drawing in the plane of a map, north up, for a page (SVG). Colours are as in CSS.
class MapDrawing {
 public:
  /// Which of two things that overlap is seen.
  enum class Layer { kBelow, kAbove };

  void Circle(Layer layer, const Eigen::Vector2d& p_map_m, double radius_m, absl::string_view fill,
              absl::string_view rim = "none");
  /// `pattern_m` is the length of its dashes; 0: it has none.
  void Line(Layer layer, const Eigen::Vector2d& from_map_m, const Eigen::Vector2d& to_map_m,
            double width_m, absl::string_view colour, double pattern_m = 0.0);
  void Polyline(Layer layer, std::span<const Eigen::Vector2d> p_map_m, double width_m,
                absl::string_view colour);

  /// `label` tells those who do not see it what it shows.
  std::string Svg(absl::string_view label) const;

 private:
  std::string& In(Layer layer) { return layer == Layer::kBelow ? below_ : above_; }
  void Extend(const Eigen::Vector2d& p_map_m);

  Eigen::Vector2d min_m_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d max_m_ = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());
  std::string below_, above_;
};

}  // namespace dcloc
