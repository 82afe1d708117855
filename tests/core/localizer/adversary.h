#pragma once

#include <random>
#include <vector>

#include "core/localizer/localizer.h"
#include "tests/core/localizer/synthetic_world.h"

namespace dcloc {

/// Scans and fixes that are valid, half valid or neither, of a vehicle whose every input may lie.
/// They begin as those of `drive`. The same seed gives the same ones.
class Adversary {
 public:
  Adversary(const std::vector<TrueScan>& drive, unsigned seed) : drive_(drive), random_(seed) {}

  Scan NextScan();

  /// Near the newest scan's stamp, for the most part.
  PositionFix NextFix();

  bool Once(int in) { return Pick(in) == 0; }

 private:
  int Pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  double Extreme();
  void MoveClock();
  void Lie(EgoVelocity& velocity);
  void AddTicks(Scan& scan);
  void Spoil(Scan& scan);
  void Flood(Scan& scan);
  void Thin(Scan& scan);

  const std::vector<TrueScan>& drive_;
  std::mt19937 random_;
  std::size_t next_ = 0;
  Stamp now_{std::chrono::seconds(1'700'000'000)};
  Scan previous_;
};

}  // namespace dcloc
