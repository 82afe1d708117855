#include "client/evaluation/baselines/pcl_registration.h"

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <memory>

// The library holds this one: the header's would take long to compile.
extern template class pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ>;

namespace dcloc {
namespace {

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using PclRegistration = pcl::Registration<Point, Point>;

constexpr std::size_t kMinPoints = 10;

void Add(const Eigen::Vector2d& p, Cloud& cloud) {
  const Eigen::Vector2f q = p.cast<float>();
  cloud.emplace_back(q.x(), q.y(), 0.0F);
}

Cloud::Ptr LiveCloud(std::span<const GaussianPoint<2>> live) {
  auto cloud = std::make_shared<Cloud>();
  for (const GaussianPoint<2>& point : live) Add(point.mean_m, *cloud);
  return cloud;
}

// The landmarks in the predicted vehicle frame: the clouds then differ by a small motion, which
// single precision and the transform's derivatives want.
Cloud::Ptr MapCloud(const LocalMap<2>& map, const Pose2& predicted, bool with_spread) {
  const Pose2 T_predicted_local = predicted.Inverse();
  const Eigen::Matrix2d R = T_predicted_local.Rotation();
  auto cloud = std::make_shared<Cloud>();
  for (const PackedPoint<2>& point : map.points()) {
    const Eigen::Vector2d p = T_predicted_local * point.mean_m.cast<double>();
    Add(p, *cloud);
    if (!with_spread) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(point.Covariance_m2());
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d offset =
          R * axes.eigenvectors().col(i) * std::sqrt(std::max(0.0, 2.0 * axes.eigenvalues()(i)));
      Add(p + offset, *cloud);
      Add(p - offset, *cloud);
    }
  }
  return cloud;
}

Eigen::Matrix4f ToMatrix(const Pose2& pose) {
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
  matrix.topLeftCorner<2, 2>() = pose.Rotation().cast<float>();
  matrix.topRightCorner<4, 1>().head<2>() = pose.translation_m.cast<float>();
  return matrix;
}

// Aligns from `guess` and moves it; false when the library gave up or left the finite numbers.
bool Align(PclRegistration& registration, Pose2& guess) {
  Cloud aligned;
  registration.align(aligned, ToMatrix(guess));
  const Eigen::Matrix4d found = registration.getFinalTransformation().cast<double>();
  if (!registration.hasConverged() || !found.allFinite()) return false;
  guess = {.translation_m = found.topRightCorner<4, 1>().head<2>(),
           .yaw_rad = std::atan2(found(1, 0), found(0, 0))};
  return true;
}

class IcpRegistration final : public PlanarRegistration {
 public:
  std::optional<PlanarFit> Register(std::span<const GaussianPoint<2>> live, const LocalMap<2>& map,
                                    const Pose2& predicted, std::uint64_t /*seed*/) const override {
    const Cloud::Ptr source = LiveCloud(live);
    const Cloud::Ptr target = MapCloud(map, predicted, false);
    if (source->size() < kMinPoints || target->size() < kMinPoints) return std::nullopt;
    pcl::IterativeClosestPoint<Point, Point> icp;
    icp.setInputSource(source);
    icp.setInputTarget(target);
    icp.setTransformationEpsilon(1e-8);
    icp.setMaximumIterations(60);
    Pose2 T_predicted_vehicle;
    constexpr double kDistances_m[] = {2.5, 0.8};
    for (const double distance_m : kDistances_m) {
      icp.setMaxCorrespondenceDistance(distance_m);
      if (!Align(icp, T_predicted_vehicle)) return std::nullopt;
    }
    return PlanarFit{.T_local_vehicle = predicted * T_predicted_vehicle,
                     .inlier_count = static_cast<int>(source->size())};
  }
};

class NdtRegistration final : public PlanarRegistration {
 public:
  std::optional<PlanarFit> Register(std::span<const GaussianPoint<2>> live, const LocalMap<2>& map,
                                    const Pose2& predicted, std::uint64_t /*seed*/) const override {
    const Cloud::Ptr source = LiveCloud(live);
    const Cloud::Ptr target = MapCloud(map, predicted, true);
    if (source->size() < kMinPoints || target->size() < kMinPoints) return std::nullopt;
    pcl::NormalDistributionsTransform<Point, Point> ndt;
    ndt.setInputSource(source);
    ndt.setInputTarget(target);
    ndt.setMaximumIterations(40);
    ndt.setTransformationEpsilon(1e-4);
    ndt.setStepSize(0.5);
    Pose2 T_predicted_vehicle;
    constexpr float kCells_m[] = {4.0F, 2.0F};
    for (const float cell_m : kCells_m) {
      ndt.setResolution(cell_m);
      if (!Align(ndt, T_predicted_vehicle)) return std::nullopt;
    }
    return PlanarFit{.T_local_vehicle = predicted * T_predicted_vehicle,
                     .inlier_count = static_cast<int>(source->size())};
  }
};

// GICP makes its covariances from each point's neighbours.
class PclGicpRegistration final : public PlanarRegistration {
 public:
  std::optional<PlanarFit> Register(std::span<const GaussianPoint<2>> live, const LocalMap<2>& map,
                                    const Pose2& predicted, std::uint64_t /*seed*/) const override {
    const Cloud::Ptr source = LiveCloud(live);
    const Cloud::Ptr target = MapCloud(map, predicted, false);
    // It takes the covariance of twenty neighbours.
    constexpr std::size_t kNeighbours = 20;
    if (source->size() < kNeighbours || target->size() < kNeighbours) return std::nullopt;
    pcl::GeneralizedIterativeClosestPoint<Point, Point> gicp;
    gicp.setInputSource(source);
    gicp.setInputTarget(target);
    gicp.setMaxCorrespondenceDistance(2.5);
    gicp.setMaximumIterations(30);
    Pose2 T_predicted_vehicle;
    if (!Align(gicp, T_predicted_vehicle)) return std::nullopt;
    return PlanarFit{.T_local_vehicle = predicted * T_predicted_vehicle,
                     .inlier_count = static_cast<int>(source->size())};
  }
};

}  // namespace

void SilencePcl() { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); }

std::unique_ptr<PlanarRegistration> MakeIcpRegistration() {
  return std::make_unique<IcpRegistration>();
}
std::unique_ptr<PlanarRegistration> MakePclGicpRegistration() {
  return std::make_unique<PclGicpRegistration>();
}
std::unique_ptr<PlanarRegistration> MakeNdtRegistration() {
  return std::make_unique<NdtRegistration>();
}

}  // namespace dcloc
