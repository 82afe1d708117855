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
  /// What is known before the data: deviations from the rig's description, by
  /// CalibrationParameter; 0 for one that is to be left alone. That of the range scale is half the
  /// square of 4 degrees, for elevations or azimuths that spread that much; it is free only for
  /// comparison (`Calibrator`).
  CalibrationVector prior_sigma = {0.05, 0.05, 0.3, 0.035, 10.0, 0.0025};
  /// By how much one radar's beta may differ from the others': radars of one make have one waveform
  /// and one firmware, and where each is judged alone, beta takes the blame for what else is wrong
  /// with it.
  double beta_spread_s = 0.003;
  StaticPointsOptions static_points = {.min_range_m = 10.0};
  /// Returns nearer than this are left out, see `Calibrator`.
  double far_range_m = 20.0;
  /// What no amount of data narrows, by CalibrationParameter: the errors that are left on simulated
  /// drives, where neighbours that are not one scatterer still pull.
  CalibrationVector floor_sigma = {0.001, 0.001, 0.02, 0.0005, 0.5, 0.0};
  /// Beyond its noise, the size of a scatterer: first wide, so that returns of one scatterer find
  /// one another, then as it is.
  std::vector<double> scatterer_sigmas_m = {1.0, 0.6, 0.4, 0.3, 0.3};
  int iterations_per_sigma = 4;
  double max_pair_distance_m = 2.0;
  std::size_t max_pairs_per_return = 24;
  std::size_t max_returns = 100'000;  ///< of more an even choice is taken
  double stand_distance_m = 3.0;  ///< returns seen from poses nearer than this share their errors
  double block_m = 8.0;           ///< gradients of squares of this size are independent
};
std::span<const OptionField<CalibratorOptions>> FieldsOf(const CalibratorOptions& options);

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const CalibratorOptions& options);

/// Estimates what is wrong with the description of each radar of a rig from static returns at known
/// vehicle poses: beta, the time by which measurements are later than their stamps, a range bias
/// and a yaw of the mount (METHOD 1: they mimic each other, so all are free).
///
/// Returns of one scatterer, seen by other radars or from elsewhere, must coincide in the map: the
/// parameters draw all pairs of returns together that overlap as Gaussians (which needs no
/// landmarks and no decisions about what belongs together), from a wide kernel to a narrow one.
/// What the data are worth is the Godambe information H V^-1 H with V from the spread of the
/// gradient over places, so that neither repeated views nor the size of objects count as knowledge;
/// it is joined with the prior.
///
/// Two more estimates are made, one with near returns, too, and one with a free range scale. What
/// differs from them is not noise, but what the model leaves out (how high scatterers are, extended
/// objects): an error that is common to the radars, which see one world, and one of each radar's
/// own, which widen the covariance. What of the corrections is then worth applying, `ChooseApplied`
/// says. Deterministic.
class Calibrator {
 public:
  /// InvalidArgument names what is wrong with the rig or the options.
  static absl::StatusOr<Calibrator> Create(Rig rig, CalibratorOptions options = {});

  /// Adds one scan taken at `T_map_vehicle`, a reference in the map frame named `frame`; drives in
  /// one frame that pass the same places tell most. InvalidArgument for an invalid scan, an unknown
  /// radar or a pose that is not finite.
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
