#pragma once

#include <map>
#include <optional>

#include "client/datasets/drive.h"

namespace dcloc::paper {

/// How much faster the vehicle was at a scan of the live drive than at the map drive's nearest
/// place, by the reference poses.
class SpeedDifferences {
 public:
  /// Both drives in one frame.
  SpeedDifferences(const Drive& map, const Drive& live);

  /// [m/s]; nothing at stamps that are no scan of the live drive.
  std::optional<double> At(Stamp stamp) const;

 private:
  std::map<Stamp, double> differences_mps_;
};

}  // namespace dcloc::paper
