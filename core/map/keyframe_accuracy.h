#pragma once

#include <cstdint>
#include <optional>

namespace dcloc {

/// How well vehicles can expect to know where they are at a keyframe, as a map file holds it.
struct KeyframeAccuracy {
  /// In the vehicle's frame.
  struct Sigmas {
    double along_m = 0.0;
    double across_m = 0.0;
    double heading_rad = 0.0;
  };
  std::optional<Sigmas> sigmas;  ///< absent where no vehicle could be localized
  bool is_tunnel = false;        ///< radars do not observe the way along
  bool is_alias = false;         ///< it looks like another place of the map
};

/// The word of a keyframe's record, not 0. Deviations are rounded to one percent, and to the
/// nearest that a word can hold: 1 mm to 24 m, 0.1 mrad to 2.4 rad.
std::uint32_t PackAccuracy(const KeyframeAccuracy& accuracy);

/// The inverse; nothing for 0, which says that nobody has looked.
std::optional<KeyframeAccuracy> UnpackAccuracy(std::uint32_t word);

/// Whether it is 0 or what `PackAccuracy` makes.
bool IsAccuracyWord(std::uint32_t word);

}  // namespace dcloc
