#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

namespace dcloc::load {

/// Durations, counted in steps of one per cent from 1 us to 1000 s: a quantile is right to one per
/// cent, and memory does not grow with time.
class LatencyHistogram {
 public:
  LatencyHistogram();

  void Add(std::chrono::nanoseconds duration);
  void Add(const LatencyHistogram& other);
  void Clear();

  std::int64_t count() const { return count_; }

  /// The smallest duration that is not exceeded by a share of `p` [0, 1] of all, at most one per
  /// cent too long; 0 without any.
  double QuantileMs(double p) const;
  double max_ms() const { return max_ms_; }
  double MeanMs() const;

 private:
  std::vector<std::int64_t> buckets_;
  std::int64_t count_ = 0;
  double sum_ms_ = 0.0;
  double max_ms_ = 0.0;
};

}  // namespace dcloc::load
