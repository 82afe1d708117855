#pragma once

#include <Eigen/Core>
#include <vector>

namespace dcloc::simulation {

/// A place on a path, in the map's plane.
struct PathPoint {
  Eigen::Vector2d position_m;
  double heading_rad = 0.0;            ///< not wrapped: continuous along the path
  double curvature_per_m = 0.0;        ///< positive turns left
  double curvature_rate_per_m2 = 0.0;  ///< d curvature / d arc length
};

/// A planar curve by arc length whose curvature has a continuous derivative, starting at the origin
/// along x. Before its start and after its end it goes on straight, or round again if it is closed.
///
/// Heading is exact; positions are Gauss-Legendre integrals good to about 1e-12 m.
class Path {
 public:
  Path();

  /// Adds `length_m` > 0 over which the curvature blends smoothly to `end_curvature_per_m`.
  void Append(double length_m, double end_curvature_per_m);

  /// A bend by `angle_rad` (positive left) at radius `radius_m`, entered and left by blends of
  /// `blend_m` each; no shorter than the two blends, so a small angle gets a larger radius.
  void AppendBend(double angle_rad, double radius_m, double blend_m);

  /// Makes it a ring: its end must lie at its start, in the same direction. Nothing is appended
  /// afterwards.
  void Close() { is_closed_ = true; }
  bool is_closed() const { return is_closed_; }

  /// The same curve from its end to its start.
  Path Reversed() const;

  PathPoint At(double s_m) const;

  double length_m() const { return pieces_.empty() ? 0.0 : pieces_.back().end_m; }

 private:
  struct Piece {
    double begin_m, end_m;
    double begin_curvature, end_curvature;
    double begin_heading_rad;
    std::vector<Eigen::Vector2d> knots_m;  ///< positions at equal steps, the first at begin_m
    double step_m;
  };

  static double HeadingIn(const Piece& piece, double s_m);
  static Eigen::Vector2d Integrate(const Piece& piece, double from_m, double to_m);

  PathPoint Within(double s_m) const;

  std::vector<Piece> pieces_;
  PathPoint start_;
  PathPoint end_;
  bool is_closed_ = false;
};

/// The point `offset_m` to the left of the path at `s_m`.
Eigen::Vector2d OffsetPoint(const Path& path, double s_m, double offset_m);

/// Unit vectors along a heading and to its left.
Eigen::Vector2d Along(double heading_rad);
Eigen::Vector2d LeftOf(double heading_rad);

}  // namespace dcloc::simulation
