#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/radar/scan.h"

namespace dcloc {

/// Notices radars that send again what they sent before, under new stamps: a buffer that is not
/// filled anew. What a radar really sees while its vehicle moves never repeats to the bit.
class RepeatedTargets {
 public:
  explicit RepeatedTargets(std::size_t radar_count) : radars_(radar_count) {}

  /// Takes in a scan of radar `index`. Whether its targets are, to the bit, those of one of the
  /// radar's last scans. A few targets may repeat by chance, and tell nothing.
  bool OnScan(std::size_t index, const Scan& scan);

 private:
  static constexpr std::size_t kScanCount = 64;
  static constexpr std::size_t kMinTargetCount = 5;

  struct Sent {
    std::array<std::uint64_t, kScanCount> fingerprints{};
    std::size_t count = 0;  // ever added
  };
  std::vector<Sent> radars_;
};

}  // namespace dcloc
