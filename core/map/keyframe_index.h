#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/map/map_file.h"

namespace dcloc {

/// Width of the index's cells in the maps that are made here.
inline constexpr double kIndexCell_m = 32.0;
/// Landmarks lie no further from their keyframe, in maps that are made here.
inline constexpr double kMaxKeyframeDistance_m = 120.0;

/// One record per keyframe: the square cell of `cell_m` in the xy plane that it lies in; ascending
/// by (cell_x, cell_y, keyframe).
std::vector<IndexRecord> MakeIndex(std::span<const KeyframeRecord> keyframes, double cell_m);

/// OK when `index` is what `MakeIndex` returns for these keyframes; otherwise DataLoss names the
/// first wrong record.
absl::Status CheckIndex(std::span<const IndexRecord> index,
                        std::span<const KeyframeRecord> keyframes, double cell_m);

/// Finds keyframes by position, in place in a file. All positions are local (see InfoRecord).
class KeyframeIndex {
 public:
  /// `index` has passed `CheckIndex`; both spans outlive this.
  KeyframeIndex(std::span<const IndexRecord> index, std::span<const KeyframeRecord> keyframes,
                double cell_m);

  /// Indices, ascending, of the keyframes within `radius_m` of `p_local_m` in xy.
  std::vector<std::size_t> Within(const Eigen::Vector2d& p_local_m, double radius_m) const;

  /// The same, into `found`, whose former contents are replaced; its memory is reused.
  void Within(const Eigen::Vector2d& p_local_m, double radius_m,
              std::vector<std::size_t>& found) const;

  /// The nearest keyframe in xy, if one lies within `max_distance_m`; of equally near ones the
  /// first.
  std::optional<std::size_t> Nearest(const Eigen::Vector2d& p_local_m, double max_distance_m) const;

 private:
  // Calls visit(keyframe, squared distance) for those within `radius_m`, by ascending cell.
  template <typename Visit>
  void ForEachWithin(const Eigen::Vector2d& p_local_m, double radius_m, const Visit& visit) const;

  std::span<const IndexRecord> index_;
  std::span<const KeyframeRecord> keyframes_;
  double cell_m_;
  Eigen::Vector2d min_m_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d max_m_ = Eigen::Vector2d::Zero();
};

}  // namespace dcloc
