#include "core/odometry/source_diagnosis.h"

#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

// Readings that agree to so much are the same reading.
constexpr double kSame = 1e-6;
// A factor that varies by less is constant.
constexpr double kScaleSpread = 0.1;

}  // namespace

void SourceDiagnosis::OnReading(double reading, double moved) {
  readings_[count_ % kKept] = {reading, moved};
  ++count_;
}

template <typename Predicate>
bool SourceDiagnosis::All(Predicate predicate) const {
  return std::all_of(readings_.begin(), readings_.begin() + static_cast<std::ptrdiff_t>(size()),
                     predicate);
}

template <typename Of>
bool SourceDiagnosis::IsConstant(Of of, double tolerance) const {
  double least = of(readings_[0]);
  double greatest = least;
  for (std::size_t i = 1; i < size(); ++i) {
    least = std::min(least, of(readings_[i]));
    greatest = std::max(greatest, of(readings_[i]));
  }
  return greatest - least <= tolerance;
}

SourceFault SourceDiagnosis::fault() const {
  if (count_ == 0) return SourceFault::kSlip;
  const bool moves = All([&](const Reading& r) { return std::abs(r.moved) > tolerance_; });
  if (moves && All([&](const Reading& r) { return std::abs(r.said) <= tolerance_; })) {
    return SourceFault::kStanding;
  }
  if (count_ >= 3 && IsConstant([](const Reading& r) { return r.said; }, kSame)) {
    return SourceFault::kFrozen;
  }
  if (moves) {
    const auto factor = [](const Reading& r) { return r.said / r.moved; };
    const bool is_negative = All([&](const Reading& r) { return factor(r) < 0.0; });
    if (is_negative &&
        All([&](const Reading& r) { return std::abs(r.said + r.moved) <= tolerance_; })) {
      return SourceFault::kSign;
    }
    if (!is_negative && count_ >= 3 && IsConstant(factor, kScaleSpread)) {
      return SourceFault::kScale;
    }
  }
  const auto difference = [](const Reading& r) { return r.said - r.moved; };
  if (count_ >= 3 && IsConstant(difference, tolerance_)) return SourceFault::kBias;
  return SourceFault::kSlip;
}

}  // namespace dcloc
