#pragma once

#include <Eigen/Core>
#include <chrono>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/odometry/rig_knowledge.h"
#include "core/odometry/two_sided_cusum.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// Noise of `OdometryErrorFilter`. The first four are the deviations of its constants before the
/// first registration.
struct OdometryErrorFilterOptions {
  double scale_sigma = 0.01;                ///< tyres are known to a percent or so
  double yaw_rate_bias_sigma_radps = 1e-3;  ///< of a gyroscope that was zeroed at rest
  double sideslip_sigma_rad = 0.01;         ///< mounts that are turned
  double time_offset_sigma_s = 0.03;        ///< clocks that differ
  double min_scale_sigma = 0.002;           ///< of the correction: load and tyres change
  // Standard deviations of a registered pose beside its own noise: the map's errors, which
  // registrations near one another share.
  double pose_sigma_m = 0.1;      ///< of the position
  double pose_sigma_rad = 0.004;  ///< of the heading
  // Standard deviations of what a second adds: to the pose, by slip and noise of the sensors; to
  // the constants, as they drift.
  double walk_sigma_m = 0.02;               ///< to the position
  double walk_sigma_rad = 5e-4;             ///< to the heading
  double scale_drift = 2e-4;                ///< to the scale
  double yaw_rate_bias_drift_radps = 2e-5;  ///< to the yaw rate's bias
  double sideslip_drift_rad = 2e-4;         ///< to the side-slip angle
  // The innovation scale is the mean of squared innovations in units of their covariance.
  double innovation_forgetting_factor = 0.97;  ///< weight of an older one beside the next, [0, 1)
  double max_squared_sigmas = 9.0;             ///< the most that one counts
  double innovation_prior_count = 3.0;         ///< innovations of 1 that the mean begins as
  double usual_squared_sigmas = 3.0;           ///< a single one beyond this widens its own noise
  /// After one beyond this the filter's pose begins again where the vehicle was registered: no
  /// constant makes so much of a moment, as a turn does that a faulty gyroscope has missed.
  double missed_squared_sigmas = 25.0;
  /// When the bias is said to have changed at once, and not to have drifted.
  TwoSidedCusumOptions change;
  /// What is further off is no error of a zero, and is not corrected.
  double max_yaw_rate_bias_radps = kMaxKnownYawRateCorrection_radps;
  /// Poses further apart are not compared.
  std::chrono::nanoseconds max_change_interval = std::chrono::seconds(3);
};
std::span<const OptionField<OdometryErrorFilterOptions>> FieldsOf(
    const OdometryErrorFilterOptions& options);
absl::Status Validate(const OdometryErrorFilterOptions& options);

/// Learns what is constantly wrong with the motion that the vehicle reports: by which factor its
/// speed is too low, and by how much its yaw rate. A Kalman filter over the vehicle's planar pose
/// and four constants that drift slowly: scale, yaw-rate bias, sideslip and time offset. The last
/// two are not used; without them a turned mount would look like a yaw-rate bias, and a delay at
/// changing speed like a scale. Registered poses are the measurements. If innovations exceed their
/// covariance, the measurement noise is scaled up. A bias that changes at once, as when a gyroscope
/// is set anew, is found by the motion between neighbouring poses, and learned afresh
/// (METHOD eq 48). A scale that changes at once is found elsewhere, as registrations do not
/// distinguish it from slip soon enough (METHOD eq 58).
class OdometryErrorFilter {
 public:
  explicit OdometryErrorFilter(const OdometryErrorFilterOptions& options);

  /// What the reported speed is to be multiplied by, and the deviation of that.
  double scale() const { return scale_; }
  double scale_sigma() const;

  /// What is to be added to the reported yaw rate.
  double yaw_rate_bias_radps() const { return yaw_rate_bias_radps_; }
  double yaw_rate_bias_sigma_radps() const;

  /// An earlier session found this of scale and yaw-rate bias: where learning begins, no more
  /// certain than without it.
  void Restore(const std::optional<ScalarEstimate>& scale,
               const std::optional<ScalarEstimate>& yaw_rate_bias_radps);

  /// What was learned so far, where that is more than was known before the first pose.
  std::optional<ScalarEstimate> LearnedScale() const;
  std::optional<ScalarEstimate> LearnedYawRateBias() const;

  /// The vehicle moved so since the last call, by odometry that was corrected as said above. The
  /// wheels' scale is learned of a speed that is theirs alone.
  enum class SpeedOrigin { kWheels, kOther };
  void OnMotion(const Pose3& T_from_to, std::chrono::nanoseconds duration,
                SpeedOrigin speed_origin = SpeedOrigin::kWheels);

  /// A registration of scans that no other one took puts the vehicle here, with a covariance of
  /// (x, y, yaw) in the tangent space on the right.
  void OnPose(const Pose3& T_map_vehicle, const Eigen::Matrix3d& covariance);

  /// Another source says what the reported speed is to be multiplied by, from now or long ago: a
  /// measurement beside the poses, and independent of them.
  void OnScale(const ScalarEstimate& scale);

  /// The scale is larger by this share than it was. What was taken for the motion since the last
  /// poses was not, so the next one starts the filter's pose again.
  void OnScaleChange(const ScalarEstimate& change);

  /// The next pose is of another place, or the motion in between is not known: it is compared with
  /// none before it.
  void OnDiscontinuity() {
    T_map_vehicle_.reset();
    last_pose_.reset();
  }

  /// The pose is doubted: the next one starts the filter's pose again. How far the vehicle has
  /// turned since the last one still tells of the gyroscope: a bias that makes registrations
  /// contradict the pose again and again is learned by nothing else.
  void OnDoubt() { T_map_vehicle_.reset(); }

 private:
  static constexpr int kPose = 3;  // x, y, yaw
  static constexpr int kStates = 7;
  using States = Eigen::Matrix<double, kStates, 1>;
  using Covariance = Eigen::Matrix<double, kStates, kStates>;

  void StartAt(const Pose3& T_map_vehicle, const Eigen::Matrix3d& covariance);
  double InnovationScaleOfLate() const;
  double InnovationScale(double squared_sigmas);
  bool HasChangedAtOnce(const Pose2& T_map_vehicle, const Eigen::Matrix3d& noise);
  void SetVariance(int state, double variance);
  void TakeConstants(const States& step);

  OdometryErrorFilterOptions options_;
  std::optional<Pose3> T_map_vehicle_;  // height and tilt as last registered
  double scale_ = 1.0;
  double yaw_rate_bias_radps_ = 0.0;
  double sideslip_rad_ = 0.0;
  double time_offset_s_ = 0.0;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  // in the tangent space, per second
  Covariance covariance_ = Covariance::Zero();
  // Squared deviations of measurements by their expectation, and how many; older ones count less.
  double squared_sigmas_ = 0.0;
  double count_ = 0.0;

  // The last pose, and by how much the vehicle turned since, by odometry.
  struct LastPose {
    Pose2 T_map_vehicle;
    Eigen::Matrix3d noise;
    double turn_rad = 0.0;
    std::chrono::nanoseconds duration{0};
  };
  std::optional<LastPose> last_pose_;
  TwoSidedCusum bias_change_;
};

}  // namespace dcloc
