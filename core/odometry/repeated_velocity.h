#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

namespace dcloc {

/// What a vehicle reports of its motion, before anything corrects it.
struct ReportedVelocity {
  double speed_mps = 0.0;
  double yaw_rate_radps = 0.0;

  friend bool operator==(const ReportedVelocity&, const ReportedVelocity&) = default;
};

/// What it says of wheels and gyroscope that the vehicle reports the same velocity once more, to
/// the last bit. While it moves, sources that work seldom do so both at once, and a bus that is
/// frozen does nothing else. How often it happens in good health is learned, for the first time and
/// once more, as readings may be coarse or rare (METHOD section 15).
class RepeatedVelocity {
 public:
  /// Takes in what the vehicle reports, nothing where it is silent.
  void OnVelocity(const std::optional<ReportedVelocity>& reported) {
    log_failed_ = 0.0;
    repeats_ = false;
    if (!reported) return;
    // What is 0 may well go on to be: the vehicle stands, or drives straight ahead.
    const bool is_compared =
        before_ && reported->speed_mps != 0.0 && reported->yaw_rate_radps != 0.0;
    Usual& usual = repeated_ ? usual_again_ : usual_first_;
    repeats_ = is_compared && *reported == *before_;
    repeated_ = repeats_;
    before_ = reported;
    if (repeats_) {
      log_failed_ = std::max(0.0, std::log(kFrozenFraction / usual.fraction));
      run_log_ = std::min(kMaxLog, run_log_ + log_failed_);
    } else {
      log_failed_ = -run_log_;
      run_log_ = 0.0;
    }
    if (is_compared && !is_frozen()) usual.Add(repeats_);
  }

  /// By how much the newest velocity makes it likelier that both sources have failed, beside their
  /// being sound, as the logarithm of the ratio. What a run has said is taken back when it ends.
  double log_failed() const { return log_failed_; }

  /// Whether the newest velocity is the one before it: what it says is no news.
  bool repeats() const { return repeats_; }

  /// Whether the last ones have said that both sources are frozen.
  bool is_frozen() const { return run_log_ >= kFrozenLog; }

 private:
  // Of the velocities of sources that have failed, so many repeat the one before.
  static constexpr double kFrozenFraction = 0.5;
  // No more of what a run has said is taken back.
  static constexpr double kMaxLog = 15.0;
  // One that has said this is called frozen.
  static constexpr double kFrozenLog = 7.0;
  // Of those of sound sources, so many do, as if so many had been seen.
  static constexpr double kUsualFraction = 0.02;
  static constexpr double kUsualCount = 20.0;
  // Velocities that are remembered.
  static constexpr double kMaxCount = 1500.0;

  // How often sound sources do.
  struct Usual {
    void Add(bool repeats) {
      count = std::min(count + 1.0, kMaxCount);
      fraction += ((repeats ? 1.0 : 0.0) - fraction) / count;
      fraction = std::max(fraction, kUsualFraction);
    }
    double fraction = kUsualFraction;
    double count = kUsualCount;
  };

  std::optional<ReportedVelocity> before_;
  Usual usual_first_;  // after a velocity that differed from the one before it
  Usual usual_again_;  // after one that did not
  double run_log_ = 0.0;
  double log_failed_ = 0.0;
  bool repeats_ = false;
  bool repeated_ = false;  // the last one that was given
};

}  // namespace dcloc
