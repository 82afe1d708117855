#include "client/load/latency_histogram.h"

#include <algorithm>
#include <cmath>

namespace dcloc::load {
namespace {

constexpr double kMin_ms = 1e-3;
constexpr double kMax_ms = 1e6;
constexpr double kStep = 1.01;

std::size_t BucketOf(double duration_ms) {
  if (duration_ms <= kMin_ms) return 0;
  return static_cast<std::size_t>(
      std::ceil(std::log(std::min(duration_ms, kMax_ms) / kMin_ms) / std::log(kStep)));
}

double UpperBoundMs(std::size_t bucket) {
  return kMin_ms * std::pow(kStep, static_cast<double>(bucket));
}

}  // namespace

LatencyHistogram::LatencyHistogram() : buckets_(BucketOf(kMax_ms) + 1) {}

void LatencyHistogram::Add(std::chrono::nanoseconds duration) {
  const double duration_ms = std::chrono::duration<double, std::milli>(duration).count();
  ++buckets_[BucketOf(duration_ms)];
  ++count_;
  sum_ms_ += duration_ms;
  max_ms_ = std::max(max_ms_, duration_ms);
}

void LatencyHistogram::Add(const LatencyHistogram& other) {
  for (std::size_t i = 0; i < buckets_.size(); ++i) buckets_[i] += other.buckets_[i];
  count_ += other.count_;
  sum_ms_ += other.sum_ms_;
  max_ms_ = std::max(max_ms_, other.max_ms_);
}

void LatencyHistogram::Clear() { *this = LatencyHistogram(); }

double LatencyHistogram::QuantileMs(double p) const {
  const auto rank = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(std::ceil(p * static_cast<double>(count_))));
  std::int64_t seen = 0;
  for (std::size_t i = 0; i < buckets_.size(); ++i) {
    seen += buckets_[i];
    if (seen >= rank) return std::min(UpperBoundMs(i), max_ms_);
  }
  return 0.0;
}

double LatencyHistogram::MeanMs() const {
  return count_ == 0 ? 0.0 : sum_ms_ / static_cast<double>(count_);
}

}  // namespace dcloc::load
