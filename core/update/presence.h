#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace dcloc {

/// What one pass says of one landmark.
struct PassEvidence {
  double expected_hits = 0.0;  ///< Lambda, did it stand (`DetectionModel`)
  int hits = 0;                ///< scans that saw it
  double days_before = 0.0;    ///< since the pass before, or since the base map was made
};

/// How hits scatter, and what is expected of landmarks before any is looked at.
struct PresenceModel {
  /// Hits of a landmark that stands are negative binomial about g Lambda, with `pass_shape`; its
  /// own strength g is Gamma of mean 1 with `strength_shape`.
  double strength_shape = 1.0;
  double pass_shape = 2.0;
  /// A place where nothing stands is hit by this share of passes, geometrically with this mean.
  double false_share = 0.05;
  double false_hits = 3.0;
  double gone_per_day = 1.0 / 2000.0;  ///< survival: exp(-t gone_per_day)
  double went_before = 0.1;            ///< share that went between the base map and the first pass
  double comes_and_goes = 0.1;         ///< share of what is there one day and not the next
  double never = 0.3;                  ///< share of candidates that are nothing
};

/// The probabilities of what a landmark is; their sum is 1.
struct Presence {
  double stays = 0.0;  ///< was there before the first pass, and is
  double came = 0.0;   ///< came between two passes or before the first, and is
  double went = 0.0;
  double comes_and_goes = 0.0;
  double never = 0.0;     ///< nothing that lasts was ever there
  std::size_t since = 0;  ///< the likeliest first pass of what came, or of the absence
};

/// Of a landmark of the base map.
Presence JudgeKnown(std::span<const PassEvidence> passes, const PresenceModel& model);

/// Of a place that the base map has not and some pass saw something at.
Presence JudgeNew(std::span<const PassEvidence> passes, const PresenceModel& model);

/// The logarithm of how likely the hits on a landmark of the base map are, whatever became of it.
double LogEvidence(std::span<const PassEvidence> passes, const PresenceModel& model);

}  // namespace dcloc
