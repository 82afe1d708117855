#include "client/simulation/world/path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace dcloc::simulation {
namespace {

constexpr double kKnotStep = 1.0;  // [m]

// Smoothstep 3u^2 - 2u^3, its integral from 0, and its derivative.
double Blend(double u) { return u * u * (3.0 - 2.0 * u); }
double BlendIntegral(double u) { return u * u * u * (1.0 - 0.5 * u); }
double BlendRate(double u) { return 6.0 * u * (1.0 - u); }

}  // namespace

Path::Path() { start_.position_m = end_.position_m = Eigen::Vector2d::Zero(); }

double Path::HeadingIn(const Piece& piece, double s_m) {
  const double length = piece.end_m - piece.begin_m;
  const double u = (s_m - piece.begin_m) / length;
  return piece.begin_heading_rad +
         length * (piece.begin_curvature * u +
                   (piece.end_curvature - piece.begin_curvature) * BlendIntegral(u));
}

Eigen::Vector2d Path::Integrate(const Piece& piece, double from_m, double to_m) {
  // Five-point Gauss-Legendre on [-1, 1].
  constexpr std::array<double, 5> kNodes = {0.0, 0.5384693101056831, -0.5384693101056831,
                                            0.9061798459386640, -0.9061798459386640};
  constexpr std::array<double, 5> kWeights = {0.5688888888888889, 0.4786286704993665,
                                              0.4786286704993665, 0.2369268850561891,
                                              0.2369268850561891};
  const double half = 0.5 * (to_m - from_m);
  const double middle = 0.5 * (to_m + from_m);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < kNodes.size(); ++i) {
    sum += kWeights[i] * Along(HeadingIn(piece, middle + half * kNodes[i]));
  }
  return half * sum;
}

void Path::Append(double length_m, double end_curvature_per_m) {
  const double begin_m = this->length_m();
  Piece piece{begin_m,
              begin_m + length_m,
              end_.curvature_per_m,
              end_curvature_per_m,
              end_.heading_rad,
              {end_.position_m},
              0.0};
  const int count = std::max(1, static_cast<int>(std::ceil(length_m / kKnotStep)));
  piece.step_m = length_m / count;
  for (int i = 0; i < count; ++i) {
    const double from = begin_m + i * piece.step_m;
    piece.knots_m.push_back(piece.knots_m.back() + Integrate(piece, from, from + piece.step_m));
  }
  end_ = {piece.knots_m.back(), HeadingIn(piece, piece.end_m), end_curvature_per_m, 0.0};
  pieces_.push_back(std::move(piece));
}

void Path::AppendBend(double angle_rad, double radius_m, double blend_m) {
  // Each blend turns by half of what its length would at full curvature.
  const double arc_m = std::max(0.1, std::abs(angle_rad) * radius_m - blend_m);
  const double curvature = angle_rad / (arc_m + blend_m);
  Append(blend_m, curvature);
  Append(arc_m, curvature);
  Append(blend_m, 0.0);
}

Path Path::Reversed() const {
  Path reversed;
  reversed.is_closed_ = is_closed_;
  reversed.start_ = {end_.position_m, end_.heading_rad + std::numbers::pi, 0.0, 0.0};
  reversed.end_ = {start_.position_m, start_.heading_rad + std::numbers::pi, 0.0, 0.0};
  for (auto piece = pieces_.rbegin(); piece != pieces_.rend(); ++piece) {
    // The blend of curvatures is symmetric, so that the way back is a piece like this one.
    reversed.pieces_.push_back({length_m() - piece->end_m,
                                length_m() - piece->begin_m,
                                -piece->end_curvature,
                                -piece->begin_curvature,
                                HeadingIn(*piece, piece->end_m) + std::numbers::pi,
                                {piece->knots_m.rbegin(), piece->knots_m.rend()},
                                piece->step_m});
  }
  return reversed;
}

PathPoint Path::At(double s_m) const {
  if (!is_closed_ || pieces_.empty()) return Within(s_m);
  const double laps = std::floor(s_m / length_m());
  PathPoint point = Within(s_m - laps * length_m());
  point.heading_rad += laps * (end_.heading_rad - start_.heading_rad);
  return point;
}

PathPoint Path::Within(double s_m) const {
  if (pieces_.empty() || s_m < 0.0) {
    PathPoint before = start_;
    before.position_m += s_m * Along(start_.heading_rad);
    return before;
  }
  if (s_m >= length_m()) {
    PathPoint beyond = end_;
    beyond.position_m += (s_m - length_m()) * Along(end_.heading_rad);
    return beyond;
  }
  const Piece& piece = *std::upper_bound(
      pieces_.begin(), pieces_.end(), s_m,
      [](double value, const Piece& candidate) { return value < candidate.end_m; });
  const double length = piece.end_m - piece.begin_m;
  const double u = (s_m - piece.begin_m) / length;
  const double step = piece.end_curvature - piece.begin_curvature;
  const auto knot = std::min(static_cast<std::size_t>((s_m - piece.begin_m) / piece.step_m),
                             piece.knots_m.size() - 1);
  const double knot_m = piece.begin_m + static_cast<double>(knot) * piece.step_m;
  return {piece.knots_m[knot] + Integrate(piece, knot_m, s_m), HeadingIn(piece, s_m),
          piece.begin_curvature + step * Blend(u), step * BlendRate(u) / length};
}

Eigen::Vector2d OffsetPoint(const Path& path, double s_m, double offset_m) {
  const PathPoint point = path.At(s_m);
  return point.position_m + offset_m * LeftOf(point.heading_rad);
}

Eigen::Vector2d Along(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

Eigen::Vector2d LeftOf(double heading_rad) {
  return {-std::sin(heading_rad), std::cos(heading_rad)};
}

}  // namespace dcloc::simulation
