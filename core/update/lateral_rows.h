#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/pose.h"

namespace dcloc {

/// What one place says of those beside it.
struct RowVote {
  double intermittent = 0.0;  ///< the probability that it comes and goes
  double lasts = 0.0;         ///< that it is there for good, by enough witnesses
  /// Who alone missed it, as a number; none where several did.
  std::optional<std::size_t> only_witness;
};

/// Streets in rows along the way: vehicles park at one distance from the lane, and what stands for
/// good lies at others.
class LateralRows {
 public:
  /// `T_local_keyframes`, at least one, are those of a map in the order they were driven;
  /// `places_m` are relative to the same origin.
  LateralRows(std::span<const Pose3> T_local_keyframes, std::span<const Eigen::Vector2d> places_m);

  /// Of each place, the share of what comes and goes in its row, a few hundred metres each way
  /// (METHOD, section 20). Its own vote does not count, and of what one witness alone missed
  /// nothing of the witness who says the most. `votes` has one for each place.
  std::vector<double> IntermittentShares(std::span<const RowVote> votes) const;

 private:
  using Row = std::pair<int, int>;  // its segment of the way, and its offset to the left

  /// What places say, each with its weight.
  struct Tally {
    double intermittent = 0.0;
    double lasts = 0.0;
    std::map<std::size_t, double> intermittent_by;  // one witness alone

    void Add(double weight, const RowVote& vote);
    void Add(double weight, const Tally& other);
    double Share() const;
  };

  /// The sum of a row and those near it, which weigh less.
  static Tally Around(const Row& row, const std::map<Row, Tally>& rows);

  std::vector<Row> row_of_;  // of each place
};

}  // namespace dcloc
