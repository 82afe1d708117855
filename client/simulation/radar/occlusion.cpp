#include "client/simulation/radar/occlusion.h"

#include <cmath>
#include <numbers>

#include "core/geometry/pose.h"

namespace dcloc::simulation {
namespace {

constexpr int kBinCount = 720;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

int BinOf(double angle_rad) {
  const double turn = angle_rad / (2.0 * std::numbers::pi);
  return std::min(kBinCount - 1, static_cast<int>((turn - std::floor(turn)) * kBinCount));
}

double DirectionTo(const Eigen::Vector2d& offset) { return std::atan2(offset.y(), offset.x()); }

}  // namespace

double CrossingShare(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Wall& wall) {
  const Eigen::Vector2d ray = to - from;
  const Eigen::Vector2d side = wall.end_m - wall.begin_m;
  const double denominator = Cross(ray, side);
  if (std::abs(denominator) < 1e-12) return -1.0;
  const Eigen::Vector2d offset = wall.begin_m - from;
  const double along_ray = Cross(offset, side) / denominator;
  const double along_wall = Cross(offset, ray) / denominator;
  const bool crosses = along_ray > 0.0 && along_ray < 1.0 && along_wall >= 0.0 && along_wall <= 1.0;
  return crosses ? along_ray : -1.0;
}

Occlusion::Occlusion(const Eigen::Vector3d& viewpoint) : viewpoint_(viewpoint), bins_(kBinCount) {}

void Occlusion::Add(const Wall& wall) {
  const double begin = DirectionTo(wall.begin_m - viewpoint_.head<2>());
  const double turn = WrapAngle(DirectionTo(wall.end_m - viewpoint_.head<2>()) - begin);
  const int first = BinOf(turn >= 0.0 ? begin : begin + turn);
  const int last = BinOf(turn >= 0.0 ? begin + turn : begin);
  for (int bin = first;; bin = (bin + 1) % kBinCount) {
    bins_[static_cast<std::size_t>(bin)].push_back(walls_.size());
    if (bin == last) break;
  }
  walls_.push_back(wall);
}

double Occlusion::LossDb(const Eigen::Vector3d& target, double skin_m) const {
  const Eigen::Vector3d ray = target - viewpoint_;
  const double length_m = ray.head<2>().norm();
  double loss_db = 0.0;
  for (const std::size_t i : bins_[static_cast<std::size_t>(BinOf(DirectionTo(ray.head<2>())))]) {
    const Wall& wall = walls_[i];
    if (wall.loss_db == 0.0) continue;
    const double share = CrossingShare(viewpoint_.head<2>(), target.head<2>(), wall);
    if (share < 0.0 || (1.0 - share) * length_m < skin_m) continue;
    if (viewpoint_.z() + share * ray.z() < wall.height_m) loss_db += wall.loss_db;
  }
  return loss_db;
}

}  // namespace dcloc::simulation
