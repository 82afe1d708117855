#include "core/mapping/scale_estimator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

constexpr int kIterations = 20;
constexpr double kRobustSigmas = 2.0;  // at which a visit counts by half

double Square(double value) { return value * value; }

}  // namespace

std::span<const OptionField<ScaleEstimatorOptions>> FieldsOf(
    const ScaleEstimatorOptions& /*options*/) {
  using O = ScaleEstimatorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"clearance_m", &O::clearance_m, 0, 100, "every landmark is used"},
      {"max_distance_m", &O::max_distance_m, 0.1, 10},
      {"max_squared_distance", &O::max_squared_distance, 1, 100},
      {"landmark_sigma_m", &O::landmark_sigma_m, 0.01, 10},
      {"range_sigma_m", &O::range_sigma_m, 0.01, 10},
      {"offset_sigma_m", &O::offset_sigma_m, 0.01, 100},
      {"min_return_count", &O::min_return_count, 5, 1e6},
      {"min_path_m", &O::min_path_m, 1, 1000},
      {"visit_gap_ms", &O::visit_gap, 1, 1e6},
      {"visit_sigma", &O::visit_sigma, 0, 1, "what reflects is a point"},
      {"min_visit_count", &O::min_visit_count, 1, 1e9},
  };
  return kFields;
}

absl::Status Validate(const ScaleEstimatorOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

ScaleEstimator::ScaleEstimator(const RadarMap& map, const ScaleEstimatorOptions& options)
    : options_(options), grid_(options.max_distance_m) {
  for (std::size_t k = 0; k < map.info().keyframe_count; ++k) {
    const Keyframe keyframe = map.keyframe(k);
    const Eigen::Matrix2d rotation = keyframe.T_map_keyframe.Rotation().topLeftCorner<2, 2>();
    for (const MapPoint& point : keyframe.points) {
      Eigen::Matrix2d covariance;
      covariance << point.xx_m2, point.xy_m2, point.xy_m2, point.yy_m2;
      const Eigen::Vector3d p_keyframe(point.x_m, point.y_m, 0.0);
      const Eigen::Vector2d p_map = (keyframe.T_map_keyframe * p_keyframe).head<2>();
      landmarks_.push_back(
          {.p_map = p_map,
           .covariance_m2 = rotation * covariance * rotation.transpose() +
                            Square(options.landmark_sigma_m) * Eigen::Matrix2d::Identity(),
           .height_square_m2 = map.info().has_heights ? Square(point.z_m) : 0.0});
      grid_.Insert(p_map);
    }
  }
  for (Landmark& landmark : landmarks_) {
    int count = 0;
    grid_.ForEachNear(landmark.p_map, Eigen::Vector2d::Constant(options.clearance_m),
                      [&](std::uint32_t i) {
                        const double distance_m = (landmarks_[i].p_map - landmark.p_map).norm();
                        count += distance_m < options.clearance_m ? 1 : 0;
                      });
    landmark.stands_alone = count <= 1;  // itself
  }
}

void ScaleEstimator::Add(std::span<const RadarPoint> points, Stamp stamp,
                         const Pose3& T_map_vehicle, const Pose3& T_vehicle_radar) {
  const Eigen::Matrix2d rotation = T_map_vehicle.Rotation().topLeftCorner<2, 2>();
  const Eigen::Vector2d radar_m = (T_map_vehicle * T_vehicle_radar.translation_m).head<2>();
  for (const RadarPoint& point : points) {
    const std::optional<std::uint32_t> landmark =
        LandmarkOf((T_map_vehicle * point.position_m).head<2>(),
                   rotation * point.covariance_m2.topLeftCorner<2, 2>() * rotation.transpose(),
                   rotation * point.slant_per_m);
    if (!landmark || !landmarks_[*landmark].stands_alone) continue;
    Visit& visit = visits_[*landmark];
    if (visit.return_count > 0 && stamp - visit.last_stamp > options_.visit_gap) {
      Close(visit);
      visit = {};
    }
    const double range_m = (point.position_m - T_vehicle_radar.translation_m).norm();
    const Eigen::Vector2d from_landmark_m = radar_m - landmarks_[*landmark].p_map;
    Eigen::Matrix<double, 5, 1> row;
    row << 1.0, from_landmark_m, from_landmark_m.squaredNorm(), Square(range_m);
    visit.sums += row * row.transpose() / Square(2.0 * range_m * options_.range_sigma_m);
    ++visit.return_count;
    visit.last_stamp = stamp;
    visit.min_m = visit.min_m.min(from_landmark_m.array());
    visit.max_m = visit.max_m.max(from_landmark_m.array());
  }
}

// Of all landmarks, be they alone or not: a return of its neighbour is none of a landmark.
std::optional<std::uint32_t> ScaleEstimator::LandmarkOf(const Eigen::Vector2d& p_map,
                                                        const Eigen::Matrix2d& covariance_m2,
                                                        const Eigen::Vector2d& slant_per_m) const {
  std::optional<std::uint32_t> nearest;
  double least = options_.max_squared_distance;
  grid_.ForEachNear(p_map, Eigen::Vector2d::Constant(options_.max_distance_m),
                    [&](std::uint32_t i) {
                      const Landmark& landmark = landmarks_[i];
                      const Eigen::Vector2d apart_m =
                          p_map - landmark.p_map - landmark.height_square_m2 * slant_per_m;
                      const Eigen::Matrix2d covariance = covariance_m2 + landmark.covariance_m2;
                      const double squared = apart_m.dot(covariance.ldlt().solve(apart_m));
                      if (squared >= least) return;
                      least = squared;
                      nearest = i;
                    });
  return nearest;
}

// METHOD eq 70: r^2 - |x|^2 is regressed on 1, x, y and |x|^2, the last one's factor is told.
void ScaleEstimator::Close(const Visit& visit) {
  if (visit.return_count < options_.min_return_count ||
      (visit.max_m - visit.min_m).matrix().norm() < options_.min_path_m) {
    return;
  }
  Eigen::Matrix3d others = visit.sums.topLeftCorner<3, 3>();
  others.diagonal().tail<2>().array() += 1.0 / Square(2.0 * options_.offset_sigma_m);
  const Eigen::LDLT<Eigen::Matrix3d> solver(others);
  const Eigen::Vector3d with_square = visit.sums.block<3, 1>(0, 3);
  const Eigen::Vector3d with_rest = visit.sums.block<3, 1>(0, 4) - with_square;
  const double square_rest = visit.sums(3, 4) - visit.sums(3, 3);
  const double rest_rest = visit.sums(4, 4) - 2.0 * visit.sums(3, 4) + visit.sums(3, 3);
  const double information = visit.sums(3, 3) - with_square.dot(solver.solve(with_square));
  if (!(information > 0.0)) return;
  const double value = (square_rest - with_rest.dot(solver.solve(with_square))) / information;
  const double left =
      rest_rest - with_rest.dot(solver.solve(with_rest)) - Square(value) * information;
  const double residual = left / static_cast<double>(visit.return_count - 4);
  told_.push_back(
      {.value = value,
       .variance = std::max(1.0, residual) / information + Square(2.0 * options_.visit_sigma)});
}

void ScaleEstimator::EndDrive() {
  for (const auto& [landmark, visit] : visits_) Close(visit);
  visits_.clear();
}

std::optional<ScalarEstimate> ScaleEstimator::Estimate() const {
  if (told_.size() < options_.min_visit_count) return std::nullopt;
  double value = 0.0;
  double information = 0.0;
  for (int i = 0; i < kIterations; ++i) {
    double sum = 0.0;
    information = 0.0;
    for (const ScalarEstimate& told : told_) {
      const double off = told.value - value;
      const double weight =
          1.0 / (told.variance * (1.0 + Square(off / kRobustSigmas) / told.variance));
      sum += weight * off;
      information += weight;
    }
    value += sum / information;
  }
  return ScalarEstimate{.value = 0.5 * value, .variance = 0.25 / information};
}

}  // namespace dcloc
