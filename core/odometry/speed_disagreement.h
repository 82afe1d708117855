#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// How a disagreement of two speeds adds up to a distance.
struct SpeedDisagreementOptions {
  /// Registrations pull the pose back within about this: a distance of this age counts 1 / e.
  std::chrono::nanoseconds fading = std::chrono::milliseconds(1500);
  /// The time constant of what the two usually differ by.
  std::chrono::nanoseconds usual_time_constant = std::chrono::seconds(20);
  /// Speeds further apart in time are not joined.
  std::chrono::nanoseconds max_gap = std::chrono::milliseconds(500);
};
std::span<const OptionField<SpeedDisagreementOptions>> FieldsOf(
    const SpeedDisagreementOptions& options);
absl::Status Validate(const SpeedDisagreementOptions& options);

/// By how far wheels and Doppler have moved apart of late, beyond what they usually do. Until it is
/// decided which of them is right, the pose may be off by that (METHOD eq 56).
class SpeedDisagreement {
 public:
  explicit SpeedDisagreement(const SpeedDisagreementOptions& options = {}) : options_(options) {}

  /// Both are sound, and say this of `stamp`, which is not before the last one.
  void OnSpeeds(Stamp stamp, double wheels_mps, double doppler_mps);

  /// One of the two is silent or not sound at `stamp`: which one is right is decided.
  void OnDecided(Stamp stamp);

  /// Along-track, at the last stamp [m]; positive where Doppler is ahead.
  double distance_m() const { return distance_m_; }

 private:
  double Fade(Stamp stamp);

  SpeedDisagreementOptions options_;
  std::optional<Stamp> last_;
  std::optional<double> usual_mps_;  // by which Doppler is faster
  double distance_m_ = 0.0;
};

}  // namespace dcloc
