#include <gtest/gtest.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>

#include <vector>

#include "core/registration/gicp.h"
#include "tests/core/registration/point_clouds.h"

namespace dcloc {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

Cloud::Ptr ToPcl(const std::vector<GaussianPoint<3>>& points) {
  auto cloud = std::make_shared<Cloud>();
  for (const GaussianPoint<3>& point : points) {
    const Eigen::Vector3f p = point.mean_m.cast<float>();
    cloud->emplace_back(p.x(), p.y(), p.z());
  }
  return cloud;
}

// With the same round covariance everywhere and no robust kernel, uncertainty-aware GICP is
// point-to-point ICP.
TEST(GicpPclTest, EqualRoundCovariancesGivePclsIcp) {
  std::mt19937 random(21);
  const Pose3 truth = SmallMotion<3>(1.0, 0.1);
  CloudPair<3> pair = ExactPair<3>(truth, 150, 0.1, random);
  for (auto* cloud : {&pair.landmarks, &pair.live}) {
    for (GaussianPoint<3>& point : *cloud) {
      point.covariance_m2 = 0.01 * Eigen::Matrix3d::Identity();
    }
  }
  pair = Noisy<3>(pair, random);
  const Pose3 start = truth * SmallMotion<3>(0.3, 0.01);

  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  icp.setInputSource(ToPcl(pair.live));
  icp.setInputTarget(ToPcl(pair.landmarks));
  icp.setMaxCorrespondenceDistance(2.0);
  icp.setMaximumIterations(100);
  icp.setTransformationEpsilon(1e-12);
  Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
  guess.topLeftCorner<3, 3>() = start.Rotation().cast<float>();
  guess.topRightCorner<3, 1>() = start.translation_m.cast<float>();
  Cloud aligned;
  icp.align(aligned, guess);
  ASSERT_TRUE(icp.hasConverged());
  const Eigen::Matrix4d found = icp.getFinalTransformation().cast<double>();

  const GicpOptions options{.max_iterations = 100,
                            .max_correspondence_distance_m = 2.0,
                            .gate_sigmas = 100.0,
                            .huber_sigmas = 1e3,
                            .translation_tolerance_m = 1e-9,
                            .rotation_tolerance_rad = 1e-10};
  const auto result = RegisterGicp<3>(pair.live, LocalMap<3>({}, pair.landmarks), start, options);
  ASSERT_TRUE(result.converged);
  // PCL computes in single precision.
  EXPECT_LT((result.T_local_vehicle.translation_m - found.topRightCorner<3, 1>()).norm(), 2e-4);
  EXPECT_LT((result.T_local_vehicle.Rotation() - found.topLeftCorner<3, 3>()).norm(), 2e-5);
  EXPECT_GT((result.T_local_vehicle.translation_m - truth.translation_m).norm(), 1e-3)
      << "the truth is not the minimum: agreement says something";
}

}  // namespace
}  // namespace dcloc
