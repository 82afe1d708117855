#pragma once

#include <array>
#include <cstddef>

namespace dcloc {

/// What is wrong with a source that says how the vehicle moves or where it is.
enum class SourceFault : std::size_t {
  kNone,
  kSilent,    ///< it says nothing, or nothing that can be used
  kStanding,  ///< it says that the vehicle stands, which moves
  kFrozen,    ///< it repeats what it said before
  kSign,      ///< it says the opposite
  kScale,     ///< it is too large or too small by a constant factor
  kBias,      ///< it is off by a constant
  kSlip,      ///< it differs from the vehicle's motion, in no constant way
  kDoppler,   ///< a radar's range rates contradict how the vehicle moves
  kMount,     ///< a radar looks elsewhere than its mount says, or its ranges are too long or short
  kMap,       ///< a radar's targets do not lie in the map where those of others do
  kClock,     ///< its stamps are not those of the other radars, or its clock was set
  kDelay,     ///< what it says was true some time before; it is used, brought to the present
};
inline constexpr std::array<const char*, 13> kSourceFaultNames = {
    "none", "silent",  "standing", "frozen", "sign",  "scale", "bias",
    "slip", "doppler", "mount",    "map",    "clock", "delay"};

constexpr const char* NameOf(SourceFault fault) {
  return kSourceFaultNames[static_cast<std::size_t>(fault)];
}

/// Whether a source takes part in the estimate, and what is wrong with it. A fault that is
/// corrected leaves it in use: a mount, a clock or a delay that is known.
struct SourceHealth {
  bool is_used = false;
  SourceFault fault = SourceFault::kSilent;

  friend bool operator==(const SourceHealth&, const SourceHealth&) = default;
};

}  // namespace dcloc
