#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "client/datasets/drive.h"

namespace dcloc {

/// What the range rates of a radar are, inferred from its own targets.
enum class RangeRateMeaning {
  kUnknown,          ///< too few targets that would tell
  kAway,             ///< as they must be: positive for what recedes
  kTowards,          ///< the other sign
  kCompensated,      ///< over ground: about 0 for what stands
  kAwayMirrored,     ///< right, but azimuths have the other sign
  kTowardsMirrored,  ///< both have the other sign
  kOfAnotherMount,   ///< right as by the mount of `better_mount`
  kNothingFits,      ///< none of these: mount, clock or velocity are wrong
};

struct RangeRateCheck {
  std::string radar_id;
  RangeRateMeaning meaning = RangeRateMeaning::kUnknown;
  std::string better_mount;      ///< the radar whose mount fits, for kOfAnotherMount
  std::size_t target_count = 0;  ///< that tell: the vehicle moves along their line of sight
  double fitting_share = 0.0;    ///< of them, those that fit as the drive is described
  double best_share = 0.0;       ///< those that fit `meaning`
};

/// Compares each target with what a thing that stands would show, by the vehicle's own velocity, or
/// by its poses where a scan has no velocity, or one of its range rates alone. Scans with neither,
/// and slower than 2 m/s, tell nothing. A check a radar, in the rig's order. Straight ahead a radar
/// that looks ahead cannot tell its azimuth's sign: then the described one counts.
std::vector<RangeRateCheck> CheckRangeRates(const Drive& drive);

/// "positive for what recedes, as it must be", ...
std::string MeaningText(const RangeRateCheck& check);

}  // namespace dcloc
