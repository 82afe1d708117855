#include "core/registration/gicp.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

template <int Dim>
using Vector = Eigen::Matrix<double, Dim, 1>;
template <int Dim>
using Matrix = Eigen::Matrix<double, Dim, Dim>;
// Blurs below a landmark's own extent change nothing.
constexpr double kNoBlur_m = 0.02;

template <int Dim>
using Correspondences = std::span<const Correspondence<Dim>>;

// d (Exp(phi) p) / d phi at zero: the rotation's part of d (T Exp(xi) p) / d xi once both are
// written in the axes of the local frame, where the translation's part is the identity.
Eigen::Vector2d LeverArm(const Eigen::Vector2d& p) { return {-p.y(), p.x()}; }
Eigen::Matrix3d LeverArm(const Eigen::Vector3d& p) { return -Skew(p); }

// sum w G^T W G by blocks of translation and rotation, in the local frame's axes.
template <int Dim>
class InformationSum {
 public:
  static constexpr int kTurns = Pose<Dim>::kDof - Dim;
  using Arm = Eigen::Matrix<double, Dim, kTurns>;

  void Add(const Matrix<Dim>& information, const Arm& arm) {
    const Arm turned = information * arm;
    shift_ += information;
    cross_ += turned;
    turn_ += arm.transpose() * turned;
  }

  // In the vehicle frame's axes.
  TangentMatrix<Dim> InVehicle(const Matrix<Dim>& R) const {
    TangentMatrix<Dim> sum;
    sum.template topLeftCorner<Dim, Dim>() = R.transpose() * shift_ * R;
    sum.template topRightCorner<Dim, kTurns>() = R.transpose() * cross_ * TurnAxes(R);
    sum.template bottomLeftCorner<kTurns, Dim>() =
        sum.template topRightCorner<Dim, kTurns>().transpose();
    sum.template bottomRightCorner<kTurns, kTurns>() =
        TurnAxes(R).transpose() * turn_ * TurnAxes(R);
    return sum;
  }

  // The vehicle's axes of rotation in the local frame: in the plane there is one for all.
  static Eigen::Matrix<double, kTurns, kTurns> TurnAxes(const Matrix<Dim>& R) {
    if constexpr (Dim == 2) {
      return Eigen::Matrix<double, 1, 1>::Identity();
    } else {
      return R;
    }
  }

 private:
  Matrix<Dim> shift_ = Matrix<Dim>::Zero();
  Arm cross_ = Arm::Zero();
  Eigen::Matrix<double, kTurns, kTurns> turn_ = Eigen::Matrix<double, kTurns, kTurns>::Zero();
};

double HuberCost(double squared, double k) {
  return squared <= k * k ? squared : 2.0 * k * std::sqrt(squared) - k * k;
}

double HuberWeight(double squared, double k) {
  return squared <= k * k ? 1.0 : k / std::sqrt(squared);
}

template <int Dim>
double Cost(Correspondences<Dim> correspondences, const Pose<Dim>& T, double huber) {
  const Matrix<Dim> R = T.Rotation();
  double cost = 0.0;
  for (const Correspondence<Dim>& pair : correspondences) {
    const Vector<Dim> e = pair.q - (R * pair.p + T.translation_m);
    cost += HuberCost(e.dot(pair.information * e), huber);
  }
  return cost;
}

// The quadratic around T (METHOD eq 12).
template <int Dim>
struct NormalEquations {
  TangentMatrix<Dim> hessian;
  Tangent<Dim> gradient;
  double cost = 0.0;
};

template <int Dim>
NormalEquations<Dim> Linearize(Correspondences<Dim> correspondences, const Pose<Dim>& T,
                               double huber) {
  constexpr int kTurns = InformationSum<Dim>::kTurns;
  const Matrix<Dim> R = T.Rotation();
  InformationSum<Dim> hessian;
  Vector<Dim> shift = Vector<Dim>::Zero();
  Eigen::Matrix<double, kTurns, 1> turn = Eigen::Matrix<double, kTurns, 1>::Zero();
  NormalEquations<Dim> normal;
  for (const Correspondence<Dim>& pair : correspondences) {
    const Vector<Dim> turned_p = R * pair.p;
    const Vector<Dim> e = pair.q - (turned_p + T.translation_m);
    const Vector<Dim> pull = pair.information * e;
    const double squared = e.dot(pull);
    const double weight = HuberWeight(squared, huber);
    const typename InformationSum<Dim>::Arm arm = LeverArm(turned_p);
    hessian.Add(weight * pair.information, arm);
    shift -= weight * pull;
    turn -= weight * (arm.transpose() * pull);
    normal.cost += HuberCost(squared, huber);
  }
  normal.hessian = hessian.InVehicle(R);
  normal.gradient.template head<Dim>() = R.transpose() * shift;
  normal.gradient.template tail<kTurns>() = InformationSum<Dim>::TurnAxes(R).transpose() * turn;
  return normal;
}

// One step on frozen correspondences. The weights make the quadratic an upper bound of Huber's
// cost, so that its minimum costs less, but for what a turn is not linear; after a large turn that
// is looked at, and the step damped until the cost falls.
template <int Dim>
Tangent<Dim> Step(Correspondences<Dim> correspondences, const NormalEquations<Dim>& normal,
                  double huber, Pose<Dim>& T) {
  constexpr double kLinear_rad = 0.01;  // up to here sin x is x to one in 10^4
  // Damping relative to the diagonal: from none to far beyond it, in six steps.
  constexpr int kMaxAttempts = 6;
  constexpr double kFirstDamping = 1e-6;
  constexpr double kDampingFactor = 30.0;
  constexpr double kMinDiagonal = 1e-3;  // 1/m^2 and 1/rad^2, of directions without information
  double damping = kFirstDamping;
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt, damping *= kDampingFactor) {
    TangentMatrix<Dim> damped = normal.hessian;
    damped.diagonal() += damping * normal.hessian.diagonal().cwiseMax(kMinDiagonal);
    Tangent<Dim> step = -damped.ldlt().solve(normal.gradient);
    const Pose<Dim> candidate = T * Exp(step);
    if (step.template tail<Pose<Dim>::kDof - Dim>().norm() <= kLinear_rad ||
        Cost<Dim>(correspondences, candidate, huber) <= normal.cost) {
      T = candidate;
      return step;
    }
  }
  return Tangent<Dim>::Zero();
}

// METHOD eq 13-14 as eq 27 has it: H^-1 (sum w^2 G^T W G) H^-1, direction by direction, so that
// what is not observed says so.
template <int Dim>
TangentMatrix<Dim> SandwichCovariance(const TangentMatrix<Dim>& hessian,
                                      const TangentMatrix<Dim>& squared_weights) {
  const Eigen::SelfAdjointEigenSolver<TangentMatrix<Dim>> solver(hessian);
  constexpr double kMinInformation = 1.0 / kUnobserved;
  const Tangent<Dim> values = solver.eigenvalues().cwiseMax(kMinInformation);
  const TangentMatrix<Dim> inverse = solver.eigenvectors() * values.cwiseInverse().asDiagonal() *
                                     solver.eigenvectors().transpose();
  TangentMatrix<Dim> covariance = inverse * squared_weights * inverse;
  for (int i = 0; i < Pose<Dim>::kDof; ++i) {
    if (solver.eigenvalues()(i) > kMinInformation) continue;
    const Tangent<Dim> direction = solver.eigenvectors().col(i);
    covariance += kUnobserved * direction * direction.transpose();
  }
  return 0.5 * (covariance + covariance.transpose());
}

// Covariance and quality at the pose that `result` holds.
template <int Dim>
void Judge(Correspondences<Dim> correspondences, std::size_t live_count, double huber,
           Registration<Dim>& result) {
  const Matrix<Dim> R = result.T_local_vehicle.Rotation();
  InformationSum<Dim> hessian;
  InformationSum<Dim> squared_weights;
  double squared_residuals = 0.0;
  double likelihood = 0.0;
  for (const Correspondence<Dim>& pair : correspondences) {
    const Vector<Dim> turned_p = R * pair.p;
    const Vector<Dim> e = pair.q - (turned_p + result.T_local_vehicle.translation_m);
    const double squared = e.dot(pair.information * e);
    const double weight = HuberWeight(squared, huber);
    const typename InformationSum<Dim>::Arm arm = LeverArm(turned_p);
    hessian.Add(weight * pair.information, arm);
    squared_weights.Add(weight * weight * pair.information, arm);
    squared_residuals += squared;
    likelihood += std::exp(-0.5 * squared);
  }
  result.covariance = SandwichCovariance<Dim>(hessian.InVehicle(R), squared_weights.InVehicle(R));
  result.inlier_count = static_cast<int>(correspondences.size());
  if (correspondences.empty()) return;
  const auto inlier_count = static_cast<double>(correspondences.size());
  result.overlap = inlier_count / static_cast<double>(live_count);
  result.score = likelihood / static_cast<double>(live_count);
  result.residual_scale = std::sqrt(squared_residuals / (Dim * inlier_count));
}

}  // namespace

std::span<const OptionField<GicpOptions>> FieldsOf(const GicpOptions& /*options*/) {
  using O = GicpOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_iterations", &O::max_iterations, 1, 1000},
      {"max_correspondence_distance_m", &O::max_correspondence_distance_m, 0.1, 20},
      {"gate_sigmas", &O::gate_sigmas, 1e-6, 1000},
      {"huber_sigmas", &O::huber_sigmas, 1e-6, 1000},
      {"translation_tolerance_m", &O::translation_tolerance_m, 0, 10, "it runs for max_iterations"},
      {"rotation_tolerance_rad", &O::rotation_tolerance_rad, 0, 1, "it runs for max_iterations"},
      {"initial_blur_m", &O::initial_blur_m, 0, 10, "the initial guess is good"},
  };
  return kFields;
}

absl::Status Validate(const GicpOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

template <int Dim>
Registration<Dim> RegisterGicp(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
                               const Pose<Dim>& T_local_vehicle_initial, const GicpOptions& options,
                               CorrespondenceFinder<Dim>& finder) {
  Registration<Dim> result;
  result.T_local_vehicle = T_local_vehicle_initial;
  double blur_m = options.initial_blur_m;
  finder.Begin(live, map,
               {.max_distance_m = options.max_correspondence_distance_m,
                .gate_sigmas = options.gate_sigmas});
  Correspondences<Dim> correspondences;
  while (true) {
    correspondences = finder.Find(result.T_local_vehicle, blur_m);
    if (result.iterations == options.max_iterations) break;
    if (correspondences.size() < static_cast<std::size_t>(Pose<Dim>::kDof)) break;
    const NormalEquations<Dim> normal =
        Linearize<Dim>(correspondences, result.T_local_vehicle, options.huber_sigmas);
    const Tangent<Dim> step =
        Step<Dim>(correspondences, normal, options.huber_sigmas, result.T_local_vehicle);
    ++result.iterations;
    const bool sharp = blur_m == 0.0;
    blur_m = blur_m > kNoBlur_m ? 0.5 * blur_m : 0.0;
    result.converged =
        sharp && step.template head<Dim>().norm() < options.translation_tolerance_m &&
        step.template tail<Pose<Dim>::kDof - Dim>().norm() < options.rotation_tolerance_rad;
    // So small a step changes no pair worth looking for.
    if (result.converged) break;
  }
  Judge<Dim>(correspondences, live.size(), options.huber_sigmas, result);
  return result;
}

template Registration<2> RegisterGicp<2>(std::span<const GaussianPoint<2>>, const LocalMap<2>&,
                                         const Pose2&, const GicpOptions&,
                                         CorrespondenceFinder<2>&);
template Registration<3> RegisterGicp<3>(std::span<const GaussianPoint<3>>, const LocalMap<3>&,
                                         const Pose3&, const GicpOptions&,
                                         CorrespondenceFinder<3>&);

}  // namespace dcloc
