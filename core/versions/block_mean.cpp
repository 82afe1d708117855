#include "core/versions/block_mean.h"

#include <cmath>
#include <limits>
#include <numeric>

namespace dcloc {

void BlockMean::Add(double value) {
  sum_ += value;
  block_sum_ += value;
  if (++count_ % block_size_ != 0) return;
  block_means_.push_back(block_sum_ / static_cast<double>(block_size_));
  block_sum_ = 0.0;
}

double BlockMean::mean() const { return count_ == 0 ? 0.0 : sum_ / static_cast<double>(count_); }

double BlockMean::sigma() const {
  if (block_means_.size() < kMinBlocks) return std::numeric_limits<double>::infinity();
  const double count = static_cast<double>(block_means_.size());
  const double middle = std::accumulate(block_means_.begin(), block_means_.end(), 0.0) / count;
  double square = 0.0;
  for (const double one : block_means_) square += (one - middle) * (one - middle);
  return std::sqrt(square / (count - 1.0) / count);
}

}  // namespace dcloc
