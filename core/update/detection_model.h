#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/update/exposure.h"

namespace dcloc {

/// What one pass says of all landmarks: how it looked at each, and by how many scans it saw each.
struct PassSightings {
  std::vector<Exposure> exposures;
  std::vector<int> hits;
};

/// How often radars see what stands: learned from the landmarks themselves.
///
/// The hits that pass p should have of landmark i are Lambda_pi = c_i sum_b w_pb e_pib: e counts
/// the scans that looked at it in the way b (`Exposure`), w_pb is how often such a look hits in
/// this pass, and c_i is how strong landmarks are that the base map saw as often as this one.
class DetectionModel {
 public:
  /// `passes` outlive the model. `base` are the exposures of the base map's drive, `base_scans` the
  /// scans of it that saw each. `presence` weighs each landmark: the probability that it still
  /// stands.
  DetectionModel(std::span<const PassSightings> passes, std::span<const Exposure> base,
                 std::span<const int> base_scans, std::span<const double> presence);

  /// Lambda of landmark `i` of those that were learned from.
  double ExpectedHits(std::size_t pass, std::size_t i) const {
    return strength_[i] * Sum(pass, passes_[pass].exposures[i]);
  }

  /// Lambda of a landmark of mean strength.
  double ExpectedHits(std::size_t pass, const Exposure& exposure) const {
    return Sum(pass, exposure);
  }

 private:
  using Rates = std::array<double, kExposureBinCount>;
  double Sum(std::size_t pass, const Exposure& exposure) const;
  void LearnRates(std::size_t pass, std::span<const double> presence);
  void LearnStrengths(std::span<const double> presence);
  void ClassifyByBase(std::span<const Exposure> base, std::span<const int> base_scans);

  std::span<const PassSightings> passes_;
  std::vector<Rates> rates_;
  std::vector<std::size_t> class_of_;
  std::vector<double> strength_;
};

}  // namespace dcloc
