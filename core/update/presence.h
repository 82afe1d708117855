#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace dcloc {

/// What one pass says of one landmark.
struct PassEvidence {
  double expected_hits = 0.0;   ///< Lambda, did it stand (`DetectionModel`)
  int hits = 0;                 ///< scans that saw it
  double position_ratio = 1.0;  ///< how much likelier they lie there if they are its own
  double days_before = 0.0;     ///< since the pass before, or since the base map was made
};

/// How hits scatter, and what is expected of landmarks before any is looked at. Given what a
/// landmark is, its hits are as METHOD says; what is hit and does not stand is hit alike beside
/// landmarks, so that a pass that cannot see a landmark says nothing of it.
struct PresenceModel {
  /// Hits of a landmark that stands are negative binomial about g Lambda, with `pass_shape`; its
  /// own strength g is Gamma of mean 1 with `strength_shape`.
  double strength_shape = 2.0;
  double pass_shape = 4.0;
  /// Where a pass has no hit of a landmark, it has false ones by this share, geometrically with
  /// this mean.
  double false_share = 0.05;
  double false_hits = 3.0;
  double changes_per_day = 1.0 / 300.0;  ///< of what lasts: it survives t days by exp(-t changes)
  /// Shares of the base map's landmarks: of those that none of the passes finds any more (some were
  /// noise when the map was made), and of those that are there one day and not the next.
  double known_removed = 0.1;
  double known_intermittent = 0.05;
  /// Shares of candidates. The rest came.
  double found_intermittent = 0.2;
  double found_never = 0.3;
};

/// `model` where `share` of what is real comes and goes.
PresenceModel WithIntermittent(PresenceModel model, double share);

/// The probabilities of what a landmark is; their sum is 1.
struct Presence {
  double stays = 0.0;    ///< was there when the base map was made, and is
  double added = 0.0;    ///< was not, and is
  double removed = 0.0;  ///< was, and is not
  double intermittent = 0.0;
  double never = 0.0;     ///< nothing was ever there
  std::size_t since = 0;  ///< the likeliest first pass of what came, or of the absence
};

/// Of a landmark of the base map.
Presence PosteriorOfMapLandmark(std::span<const PassEvidence> passes, const PresenceModel& model);

/// Of a candidate: a place that the base map has not, and that some pass has hits of. The best
/// sighting says where it is, and so nothing of whether the others are of the same.
Presence PosteriorOfCandidate(std::span<const PassEvidence> passes, const PresenceModel& model);

/// The logarithm of how likely the hits of a landmark of the base map are, whatever became of it.
double LogEvidence(std::span<const PassEvidence> passes, const PresenceModel& model);

}  // namespace dcloc
