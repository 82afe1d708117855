#include "client/evaluation/map_drawing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace dcloc {
namespace {

using ::testing::HasSubstr;

TEST(MapDrawingTest, HoldsAllThatIsDrawnNorthUp) {
  MapDrawing drawing;
  drawing.Circle(MapDrawing::Layer::kAbove, {10.0, 20.0}, 3.0, "#fff", "#000");
  drawing.Line(MapDrawing::Layer::kBelow, {0.0, 0.0}, {-5.0, 1.0}, 0.5, "#0072b2", 2.0);
  const std::vector<Eigen::Vector2d> way = {{0.0, 0.0}, {4.0, 40.0}};
  drawing.Polyline(MapDrawing::Layer::kBelow, way, 1.0, "#bbb");
  const std::string svg = drawing.Svg("a town");
  EXPECT_THAT(svg, HasSubstr("viewBox=\"-10.0 -45.0 25.0 50.0\""));
  EXPECT_THAT(svg, HasSubstr("aria-label=\"a town\""));
  EXPECT_THAT(svg, HasSubstr("cx=\"10.0\" cy=\"-20.0\" r=\"3\" fill=\"#fff\" stroke=\"#000\""));
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray=\"2\""));
  EXPECT_LT(svg.find("<line"), svg.find("<circle")) << "what is above comes last";
}

TEST(MapDrawingTest, NothingIsNoDrawing) { EXPECT_EQ(MapDrawing().Svg("nothing"), ""); }

}  // namespace
}  // namespace dcloc
