#include "client/evaluation/pose_error.h"

#include <Eigen/Cholesky>
#include <array>
#include <limits>
#include <vector>

#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

constexpr std::array kQuantiles95 = {3.841, 5.991, 7.815, 9.488, 11.070, 12.592};
constexpr std::array kQuantiles999 = {10.828, 13.816, 16.266, 18.467, 20.515, 22.458};

double Nees(const Vector6d& tangent, const Matrix6d& covariance,
            const std::vector<Eigen::Index>& indices) {
  const Eigen::VectorXd error = tangent(indices);
  const Eigen::LLT<Eigen::MatrixXd> factors(covariance(indices, indices));
  if (factors.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return error.dot(factors.solve(error));
}

}  // namespace

PoseError ComparePoses(const Pose3& T_map_vehicle, const Matrix6d& covariance,
                       const std::bitset<6>& observed, const Pose3& T_map_vehicle_true) {
  const Pose3 T_estimate_truth = T_map_vehicle.Inverse() * T_map_vehicle_true;
  std::vector<Eigen::Index> indices;
  for (Eigen::Index i = 0; i < 6; ++i) {
    if (observed[static_cast<std::size_t>(i)]) indices.push_back(i);
  }
  PoseError error;
  error.tangent = Log(T_estimate_truth);
  error.translation_m = T_estimate_truth.translation_m.norm();
  error.rotation_deg = RotationAngle(T_estimate_truth) * kDegPerRad;
  error.dof = static_cast<int>(indices.size());
  error.nees = indices.empty() ? 0.0 : Nees(error.tangent, covariance, indices);
  return error;
}

double ChiSquare95(int dof) { return kQuantiles95.at(static_cast<std::size_t>(dof - 1)); }
double ChiSquare999(int dof) { return kQuantiles999.at(static_cast<std::size_t>(dof - 1)); }

}  // namespace dcloc
