#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/sdk/pose/pose_estimate.h"
#include "client/sdk/pose/published_timeline.h"
#include "client/sdk/pose/timeline.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

/// The pose of a vehicle at any time, from a session's answers and the velocities that the vehicle
/// gave. All members may be called from any thread; readers take no lock and do not allocate,
/// unless they are refused.
class PoseTracker {
 public:
  /// `options` are valid.
  explicit PoseTracker(const PoseOptions& options);

  /// Takes an answer. From one without a pose on, there is none.
  void AddAnswer(const v1::LocalizationResult& result);

  /// Takes the vehicle's velocity at a stamp, at any rate; 100 Hz are used. InvalidArgument names
  /// the field and the value.
  absl::Status AddVelocity(std::int64_t stamp_ns, const v1::EgoVelocity& velocity);

  /// The next answer does not follow the ones before it.
  void BeginAnew();

  /// FailedPrecondition while no answer has a pose; OutOfRange before what is kept, and later than
  /// `max_ahead` after the newest answer.
  absl::StatusOr<PoseEstimate> PoseAt(std::int64_t stamp_ns) const;

  /// The same without jumps, for controllers that ask for the present: where the newest answer or
  /// velocity moves the pose, this one follows by at most `bleed_mps` and `bleed_radps`. What is
  /// left of the jump is added to the covariance. A stamp before the newest one that was asked for
  /// gets the newest one's offset from `PoseAt`.
  absl::StatusOr<PoseEstimate> SmoothPoseAt(std::int64_t stamp_ns) const;

 private:
  /// What the server has learned of the velocities that the vehicle gives.
  struct OdometryErrors {
    double scale = 1.0;
    double scale_sigma = 0.0;
    bool knows_scale = false;
    double yaw_rate_correction_radps = 0.0;
    std::optional<double> yaw_rate_sigma_radps;  ///< of that, once it is learned
  };

  std::vector<GivenVelocity> CorrectedVelocities() const;
  void SetUsualVariances(double interval_s, GivenVelocity& given) const;
  void StartOverIfSetBack(std::int64_t stamp_ns);
  void Publish();
  bool UsesGivenVelocity() const;
  SmoothOffset OffsetTo(const std::vector<Segment>& segments) const;

  const PoseOptions options_;
  PublishedTimeline published_;

  std::mutex mutex_;  ///< of the writers
  std::vector<Anchor> anchors_;
  std::vector<GivenVelocity> given_;  ///< as the vehicle gave them
  OdometryErrors learned_;
  std::int64_t newest_ns_ = 0;
  std::int64_t reset_count_ = 0;
  bool next_answer_jumps_ = true;
  bool trusts_given_ = true;  ///< the server finds no fault with them
};

}  // namespace dcloc::client
