#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "client/evaluation/outcome.h"
#include "core/map/radar_map.h"

namespace dcloc {

/// An axis-aligned part of the map's plane.
struct Box {
  Eigen::Vector2d min = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d max = Eigen::Vector2d::Constant(-1e300);

  void Add(const Eigen::Vector2d& p) {
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
  Box Grown(double margin) const {
    return {min - Eigen::Vector2d::Constant(margin), max + Eigen::Vector2d::Constant(margin)};
  }
  bool Contains(const Eigen::Vector2d& p) const {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
};

/// The 95 % ellipse of a position in the map's plane.
struct Ellipse {
  Eigen::Vector2d centre;
  double major_diameter_m, minor_diameter_m, angle_deg;
};

/// From the drive's first scan.
double Seconds(const DriveOutcome& outcome, const ScanOutcome& scan);

Eigen::Vector2d Position(const Pose3& pose);
Ellipse PositionEllipse(const Localization& answer);

/// Of the true track.
Box TrackBox(const DriveOutcome& outcome);

/// Those of the answers, thinned evenly to about `max_count`.
std::vector<Ellipse> Ellipses(const DriveOutcome& outcome, std::size_t max_count);

/// Text as a single-quoted string of gnuplot's.
std::string Quote(absl::string_view text);

/// A named block of gnuplot data.
std::string Block(const std::string& name, const std::vector<std::string>& lines);

// Lines of such blocks:

/// x, y of the landmarks within `box`, thinned where there are very many.
std::vector<std::string> LandmarkLines(const RadarMap& map, const Box& box);

/// x, y of the reference track.
std::vector<std::string> TruthLines(const DriveOutcome& outcome);

/// time, x, y, translation error, its claimed 95 % bound, rotation error, its claimed 95 % bound;
/// metres and degrees. An empty line breaks the curve where there was no answer.
std::vector<std::string> AnswerLines(const DriveOutcome& outcome);

/// x, y, major and minor diameter times `scale`, angle of the major axis in degrees.
std::vector<std::string> EllipseLines(const std::vector<Ellipse>& ellipses, double scale);

/// Translation error, share in percent of the answered scans that have no larger one.
std::vector<std::string> DistributionLines(const DriveOutcome& outcome);

/// true x, y, answered x, y of those scans of `outcome` that have the stamp and radar of one of
/// `marked` and were answered.
std::vector<std::string> MarkLines(const DriveOutcome& outcome,
                                   const std::vector<const ScanOutcome*>& marked);

}  // namespace dcloc
