#pragma once

#include <cstddef>
#include <vector>

namespace dcloc {

/// The mean of a sequence whose neighbours share their errors, and how uncertain it is: the
/// standard error of the means of its blocks (non-overlapping batch means).
class BlockMean {
 public:
  explicit BlockMean(std::size_t block_size) : block_size_(block_size) {}

  void Add(double value);

  /// 0 without a value.
  double mean() const;

  /// Of the mean. Infinity with fewer than `kMinBlocks` full blocks: nothing can be said.
  double sigma() const;

  static constexpr std::size_t kMinBlocks = 3;

 private:
  std::size_t block_size_;
  std::size_t count_ = 0;
  double sum_ = 0.0;
  double block_sum_ = 0.0;
  std::vector<double> block_means_;
};

}  // namespace dcloc
