#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "client/evaluation/faults/stream.h"

namespace dcloc::faults {

/// What is wrong with the inputs of a session, and when.
struct Fault {
  /// Changes the stream within a window of true time; the seed is for what is drawn.
  using Apply = std::function<void(Stream&, const Window&, std::uint64_t seed)>;

  std::string id;      ///< lower-case letters, digits, '.' and '-'; unique
  std::string family;  ///< "velocity", "time", "radar", "targets", "place", "movers" or "map"
  std::string label;
  double begin_s = kBegin_s;  ///< since the first scan
  /// Nothing for a fault that stays to the end; 0 for one that happens at a moment, such as a clock
  /// that is set.
  std::optional<double> duration_s;
  Apply apply;
  std::size_t min_radars = 1;  ///< says nothing of a vehicle with fewer
  bool is_reversing = false;   ///< of a vehicle that drives backwards

  static constexpr double kBegin_s = 20.0;
};

/// When `fault` is in force over `stream`, which has scans. A moment's window is empty.
inline Window WindowOf(const Fault& fault, const Stream& stream) {
  const Stamp begin = stream.scans.front().measured + Duration(fault.begin_s);
  if (!fault.duration_s) return {begin, Stamp::max()};
  return {begin, begin + Duration(*fault.duration_s)};
}

}  // namespace dcloc::faults
