#pragma once

#include <array>
#include <cstddef>

#include "core/odometry/source_fault.h"

namespace dcloc {

/// Names what is wrong with a source that was found wrong: how its last readings differ from how
/// the vehicle moved. Speeds [m/s] or yaw rates [rad/s].
class SourceDiagnosis {
 public:
  /// `tolerance` is what sound readings differ by; a vehicle that moves less stands.
  explicit SourceDiagnosis(double tolerance) : tolerance_(tolerance) {}

  /// The source said `reading` while the vehicle moved with `moved`, as the sound sources say.
  void OnReading(double reading, double moved);

  /// The source is sound again.
  void Clear() { count_ = 0; }

  /// kSlip where the difference is no constant one, or nothing is known of it.
  SourceFault fault() const;

 private:
  static constexpr std::size_t kKept = 8;
  struct Reading {
    double said = 0.0;
    double moved = 0.0;
  };

  template <typename Of>
  bool IsConstant(Of of, double tolerance) const;
  template <typename Predicate>
  bool All(Predicate predicate) const;
  std::size_t size() const { return count_ < kKept ? count_ : kKept; }

  double tolerance_;
  std::array<Reading, kKept> readings_{};
  std::size_t count_ = 0;  // ever taken since the last Clear
};

}  // namespace dcloc
