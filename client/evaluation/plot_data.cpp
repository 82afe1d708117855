#include "client/evaluation/plot_data.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "core/geometry/chi_square.h"
#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

constexpr std::size_t kMaxLandmarks = 12'000;  // more only make the file large

}  // namespace

double Seconds(const DriveOutcome& outcome, const ScanOutcome& scan) {
  return std::chrono::duration<double>(scan.answer.stamp - outcome.scans.front().answer.stamp)
      .count();
}

Eigen::Vector2d Position(const Pose3& pose) { return pose.translation_m.head<2>(); }

Ellipse PositionEllipse(const Localization& answer) {
  const Eigen::Matrix3d R = answer.T_map_vehicle.Rotation();
  const Eigen::Matrix3d in_map = R * answer.covariance.topLeftCorner<3, 3>() * R.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(in_map.topLeftCorner<2, 2>());
  const Eigen::Vector2d diameters =
      2.0 * (ChiSquare95(2) * axes.eigenvalues().cwiseMax(0.0)).cwiseSqrt();
  const Eigen::Vector2d major = axes.eigenvectors().col(1);
  return {Position(answer.T_map_vehicle), diameters[1], diameters[0],
          std::atan2(major.y(), major.x()) * kDegPerRad};
}

Box TrackBox(const DriveOutcome& outcome) {
  Box box;
  for (const ScanOutcome& scan : outcome.scans) box.Add(Position(scan.T_map_vehicle_true));
  return box;
}

std::vector<Ellipse> Ellipses(const DriveOutcome& outcome, std::size_t max_count) {
  std::vector<Ellipse> ellipses;
  const std::size_t stride = outcome.scans.size() / max_count + 1;
  for (std::size_t i = 0; i < outcome.scans.size(); i += stride) {
    if (outcome.scans[i].answered()) ellipses.push_back(PositionEllipse(outcome.scans[i].answer));
  }
  return ellipses;
}

std::string Quote(absl::string_view text) {
  return absl::StrCat("'", absl::StrReplaceAll(text, {{"'", "''"}, {"\n", " "}}), "'");
}

std::string Block(const std::string& name, const std::vector<std::string>& lines) {
  return absl::StrCat("$", name, " << EOD\n", absl::StrJoin(lines, "\n"), "\nEOD\n");
}

std::vector<std::string> LandmarkLines(const RadarMap& map, const Box& box) {
  std::vector<std::string> all;
  for (std::size_t i = 0; i < map.info().keyframe_count; ++i) {
    const Keyframe keyframe = map.keyframe(i);
    for (const MapPoint& point : keyframe.points) {
      const Eigen::Vector3d p_map =
          keyframe.T_map_keyframe * Eigen::Vector3d(point.x_m, point.y_m, point.z_m);
      if (box.Contains(p_map.head<2>()))
        all.push_back(absl::StrFormat("%.2f %.2f", p_map.x(), p_map.y()));
    }
  }
  const std::size_t stride = all.size() / kMaxLandmarks + 1;
  std::vector<std::string> kept;
  for (std::size_t i = 0; i < all.size(); i += stride) kept.push_back(all[i]);
  return kept;
}

std::vector<std::string> TruthLines(const DriveOutcome& outcome) {
  std::vector<std::string> lines;
  for (const ScanOutcome& scan : outcome.scans) {
    const Eigen::Vector2d p = Position(scan.T_map_vehicle_true);
    lines.push_back(absl::StrFormat("%.3f %.3f", p.x(), p.y()));
  }
  return lines;
}

std::vector<std::string> AnswerLines(const DriveOutcome& outcome) {
  std::vector<std::string> lines;
  for (const ScanOutcome& scan : outcome.scans) {
    if (!scan.answered()) {
      lines.emplace_back();
      continue;
    }
    const Eigen::Vector2d p = Position(scan.answer.T_map_vehicle);
    lines.push_back(absl::StrFormat(
        "%.3f %.3f %.3f %.4f %.4f %.4f %.4f", Seconds(outcome, scan), p.x(), p.y(),
        scan.error.translation_m, 0.5 * PositionEllipse(scan.answer).major_diameter_m,
        scan.error.rotation_deg, kSigmas95 * std::sqrt(scan.answer.covariance(5, 5)) * kDegPerRad));
  }
  return lines;
}

std::vector<std::string> EllipseLines(const std::vector<Ellipse>& ellipses, double scale) {
  std::vector<std::string> lines;
  lines.reserve(ellipses.size());
  for (const Ellipse& e : ellipses) {
    lines.push_back(absl::StrFormat("%.3f %.3f %.4f %.4f %.2f", e.centre.x(), e.centre.y(),
                                    scale * e.major_diameter_m, scale * e.minor_diameter_m,
                                    e.angle_deg));
  }
  return lines;
}

std::vector<std::string> DistributionLines(const DriveOutcome& outcome) {
  std::vector<double> errors_m;
  for (const ScanOutcome& scan : outcome.scans) {
    if (scan.answered()) errors_m.push_back(scan.error.translation_m);
  }
  std::ranges::sort(errors_m);
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < errors_m.size(); ++i) {
    lines.push_back(
        absl::StrFormat("%.4f %.3f", errors_m[i],
                        100.0 * static_cast<double>(i + 1) / static_cast<double>(errors_m.size())));
  }
  return lines;
}

std::vector<std::string> MarkLines(const DriveOutcome& outcome,
                                   const std::vector<const ScanOutcome*>& marked) {
  std::vector<std::string> lines;
  for (const ScanOutcome& scan : outcome.scans) {
    const bool is_marked = std::ranges::any_of(marked, [&](const ScanOutcome* other) {
      return other->answer.stamp == scan.answer.stamp && other->radar_id == scan.radar_id;
    });
    if (!is_marked || !scan.answered()) continue;
    const Eigen::Vector2d truth = Position(scan.T_map_vehicle_true);
    const Eigen::Vector2d answer = Position(scan.answer.T_map_vehicle);
    lines.push_back(
        absl::StrFormat("%.3f %.3f %.3f %.3f", truth.x(), truth.y(), answer.x(), answer.y()));
  }
  return lines;
}

}  // namespace dcloc
