#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/calibration/calibration.h"
#include "core/calibration/return_pairs.h"
#include "core/calibration/static_return.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/radar/static_points.h"

namespace dcloc {

struct CalibratorOptions {
  /// Prior deviations from the rig's description, by CalibrationParameter; 0 for a parameter that
  /// is not to be estimated. That of the range scale is half the square of 4 degrees, for
  /// elevations or azimuths that spread that much; it is estimated only for comparison
  /// (`Calibrator`).
  CalibrationVector prior_sigma = {0.05, 0.05, 0.3, 0.035, 10.0, 0.0025};
  /// Prior deviation of one radar's beta from the others'. Radars of one make have the same
  /// waveform and firmware. If each beta were estimated alone, it would absorb other errors of its
  /// radar.
  double beta_spread_s = 0.003;
  StaticPointsOptions static_points = {.min_range_m = 10.0};
  /// Returns nearer than this are left out, see `Calibrator`.
  double far_range_m = 20.0;
  /// Lower bounds of the deviations, by CalibrationParameter, whatever the amount of data: the
  /// errors that remain on simulated drives, because neighbouring scatterers are paired.
  CalibrationVector floor_sigma = {0.001, 0.001, 0.02, 0.0005, 0.5, 0.0};
  /// Deviation of returns of one scatterer beyond their noise, in successive rounds: first wide, so
  /// that they find one another, then the actual size.
  std::vector<double> scatterer_sigmas_m = {1.0, 0.6, 0.4, 0.3, 0.3};
  int iterations_per_sigma = 4;
  double max_pair_distance_m = 2.0;
  std::size_t max_pairs_per_return = 24;
  std::size_t max_returns = 100'000;  ///< if there are more, they are thinned evenly
  double stand_distance_m = 3.0;  ///< returns seen from poses nearer than this share their errors
  double block_m = 8.0;  ///< size of the squares whose gradients are taken to be independent
};
std::span<const OptionField<CalibratorOptions>> FieldsOf(const CalibratorOptions& options);

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const CalibratorOptions& options);

/// Estimates what is wrong with the description of each radar of a rig from static returns at known
/// vehicle poses: beta, the time by which measurements are later than their stamps, a range bias
/// and a yaw of the mount (METHOD 1: their effects are alike, so all are estimated together).
///
/// Returns of one scatterer, seen by several radars or from several places, must coincide in the
/// map. The estimate minimises the distances of all pairs of returns that overlap as Gaussians,
/// with a kernel that is first wide, then narrow. That needs no landmarks and no data association.
/// The information of the data is the Godambe information H V^-1 H. V is the spread of the gradient
/// over places, so that neither repeated views nor extended objects count as more data. It is
/// combined with the prior.
///
/// Two more estimates are made: one that includes near returns, and one with a free range scale.
/// Their differences are not noise, but effects that the model leaves out (heights of scatterers,
/// extended objects). They are taken for an error common to all radars and one of each radar, which
/// widen the covariance. `ChooseApplied` decides which corrections are applied. Deterministic.
class Calibrator {
 public:
  /// InvalidArgument names what is wrong with the rig or the options.
  static absl::StatusOr<Calibrator> Create(Rig rig, CalibratorOptions options = {});

  /// Adds one scan taken at `T_map_vehicle`, a reference in the map frame named `frame`; drives in
  /// one frame that pass the same places give the most information. InvalidArgument for an invalid
  /// scan, an unknown radar or a pose that is not finite.
  absl::Status Add(const std::string& frame, const Scan& scan, const Pose3& T_map_vehicle,
                   const EgoVelocity& ego_velocity);

  /// Reports how many of how many steps are done.
  using ProgressCallback = std::function<void(std::size_t done, std::size_t total)>;

  /// FailedPrecondition when no two returns are near one another.
  absl::StatusOr<Calibration> Estimate(const ProgressCallback& progress = nullptr) const;

 private:
  struct Stand {
    Eigen::Vector2d position_m = Eigen::Vector2d::Constant(1e300);
    std::uint32_t number = 0;
  };
  struct Frame {
    Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
    std::vector<Stand> stands;  // the newest of each radar
    FrameReturns seen;
  };

  Calibrator(Rig rig, CalibratorOptions options)
      : rig_(std::move(rig)), options_(std::move(options)) {}

  Frame& FrameNamed(const std::string& name, const Eigen::Vector3d& origin_m);
  std::uint32_t StandAt(Frame& frame, const Eigen::Vector2d& position_m, std::size_t radar) const;

  Rig rig_;
  CalibratorOptions options_;
  std::map<std::string, Frame> frames_;
};

}  // namespace dcloc
