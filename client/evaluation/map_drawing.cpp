#include "client/evaluation/map_drawing.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

constexpr double kMargin_m = 5.0;

}  // namespace

void MapDrawing::Circle(Layer layer, const Eigen::Vector2d& p_map_m, double radius_m,
                        absl::string_view fill, absl::string_view rim) {
  Extend(p_map_m);
  absl::StrAppendFormat(&In(layer), "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%g\" fill=\"%s\"",
                        p_map_m.x(), -p_map_m.y(), radius_m, fill);
  if (rim != "none") absl::StrAppend(&In(layer), " stroke=\"", rim, "\"");
  absl::StrAppend(&In(layer), "/>");
}

void MapDrawing::Line(Layer layer, const Eigen::Vector2d& from_map_m,
                      const Eigen::Vector2d& to_map_m, double width_m, absl::string_view colour,
                      double pattern_m) {
  Extend(from_map_m);
  Extend(to_map_m);
  absl::StrAppendFormat(&In(layer),
                        "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" stroke=\"%s\" "
                        "stroke-width=\"%g\"",
                        from_map_m.x(), -from_map_m.y(), to_map_m.x(), -to_map_m.y(), colour,
                        width_m);
  if (pattern_m > 0.0) absl::StrAppendFormat(&In(layer), " stroke-dasharray=\"%g\"", pattern_m);
  absl::StrAppend(&In(layer), "/>");
}

void MapDrawing::Polyline(Layer layer, std::span<const Eigen::Vector2d> p_map_m, double width_m,
                          absl::string_view colour) {
  absl::StrAppendFormat(&In(layer),
                        "<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"%g\" points=\"",
                        colour, width_m);
  for (const Eigen::Vector2d& p_m : p_map_m) {
    Extend(p_m);
    absl::StrAppendFormat(&In(layer), "%.1f,%.1f ", p_m.x(), -p_m.y());
  }
  absl::StrAppend(&In(layer), "\"/>");
}

std::string MapDrawing::Svg(absl::string_view label) const {
  if (below_.empty() && above_.empty()) return "";
  const Eigen::Vector2d size_m = max_m_ - min_m_;
  return absl::StrFormat(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"%.1f %.1f %.1f %.1f\" role=\"img\" "
      "aria-label=\"%s\">%s%s</svg>\n",
      min_m_.x() - kMargin_m, -max_m_.y() - kMargin_m, size_m.x() + 2.0 * kMargin_m,
      size_m.y() + 2.0 * kMargin_m, label, below_, above_);
}

void MapDrawing::Extend(const Eigen::Vector2d& p_map_m) {
  min_m_ = min_m_.cwiseMin(p_map_m);
  max_m_ = max_m_.cwiseMax(p_map_m);
}

}  // namespace dcloc
