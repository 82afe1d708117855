#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/odometry/rig_knowledge.h"
#include "core/odometry/scalar_estimate.h"
#include "core/online_calibration/radar_delays.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// When a measured delay of a radar's stamps goes before its description.
struct LearnedStampOptions {
  RadarDelayOptions delays;
  /// A delay is measured where it is known to within this, and evident where it is as many
  /// deviations from none.
  double measured_sigma_s = 0.01;
  double evident_sigmas = 5.0;
  double min_correction_s = 0.02;     ///< the smallest correction of a described time offset
  double contradiction_sigmas = 5.0;  ///< beyond which a calibrated offset is wrong
  /// What no drive averages out. Registrations of front and side radars of one recording put their
  /// stamps 0.035 s apart, Doppler 0.010 s.
  double systematic_sigma_s = 0.015;
  double known_sigma_s = 0.005;  ///< what an earlier session found is no more certain than this
  double min_change_s = 0.005;   ///< a correction is changed by no less
};
std::span<const OptionField<LearnedStampOptions>> FieldsOf(const LearnedStampOptions& options);
absl::Status Validate(const LearnedStampOptions& options);

/// The time offset of a radar whose scans are measured to be stamped by `late_s` later than
/// `described` says, with its variance, where `assumed_late_s` was assumed before (METHOD eq 68).
/// Nothing where the description stands.
std::optional<ScalarEstimate> CorrectedTimeOffset(const RadarModel& described,
                                                  const ScalarEstimate& late_s,
                                                  const LearnedStampOptions& options,
                                                  double assumed_late_s = 0.0);

/// A rig whose time offsets were measured by a drive.
struct MeasuredStamps {
  /// Offsets that the drive contradicts are corrected, and deviations are as small as it allows.
  /// As described where the delay of one radar stays unknown: corrected points would lie beside
  /// those that are not.
  Rig rig;
  double mean_delay_s = 0.0;  ///< by how much offsets were corrected, on average
};
MeasuredStamps ToMeasuredStamps(const RadarDelays& delays, const LearnedStampOptions& options);

/// The stamps of a vehicle's radars as its drive measures them. A radar whose time_offset_sigma_s
/// is 0 is taken as described.
class LearnedStamps {
 public:
  LearnedStamps(const Rig& described, const LearnedStampOptions& options);

  /// An earlier session found this; it is handed on.
  void Restore(const RigKnowledge& known);
  void AddTo(RigKnowledge& known) const;

  /// Offsets of radars are corrected from now on, the restored ones at once. A radar is assumed to
  /// be late by `assumed_late_s`, unless it is described as well as a measured one.
  void Begin(double assumed_late_s);

  /// As RadarDelays::OnScan. Returns by how much an offset has changed, at most [s].
  double OnScan(Stamp stamp, std::size_t index, const Scan& scan, bool is_sound);

  /// The offset of radar `index`, if it is corrected, and its variance.
  const std::optional<ScalarEstimate>& time_offset_s(std::size_t index) const {
    return learned_[index].time_offset_s;
  }

 private:
  struct Learned {
    std::optional<ScalarEstimate> restored_late_s, time_offset_s;
  };
  bool IsMeasured(const ScalarEstimate& late_s) const;
  std::optional<ScalarEstimate> Offset(std::size_t index) const;
  std::optional<ScalarEstimate> Late(std::size_t index) const;
  double Correct();

  LearnedStampOptions options_;
  RadarDelays delays_;
  std::vector<Learned> learned_;
  std::optional<double> assumed_late_s_;  // since offsets are corrected
};

}  // namespace dcloc
