#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/map/radar_map.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// Positions and headings to search: where the vehicle was at an earlier time, and its motion
/// since. For each possible heading then, the position now is that position moved by `T_then_now`.
struct SearchRegion {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();  ///< in the map's xy plane
  double radius_m = 0.0;
  double yaw_rad = 0.0;
  double max_yaw_offset_rad = 0.0;  ///< from pi on every heading
  Pose2 T_then_now = {};

  /// Whether the vehicle may be here now.
  bool Contains(const Pose2& T_map_vehicle) const;

  /// Whether the vehicle may now be somewhere in the box from `min_m` to `max_m`, if its heading
  /// now is `yaw_now_rad`. The heading itself is not tested.
  bool MayContain(const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m,
                  double yaw_now_rad) const;
};

struct PlaceSearchOptions {
  double cell_m = 1.0;  ///< step between positions; headings step likewise
  /// Positions are searched within this distance of a keyframe along each of the map's axes.
  double max_keyframe_distance_m = 6.0;
  int max_count = 8;                        ///< of places that `Best` returns
  std::optional<SearchRegion> region = {};  ///< without it the whole map, in every heading
};
std::span<const OptionField<PlaceSearchOptions>> FieldsOf(const PlaceSearchOptions& options);

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const PlaceSearchOptions& options);

/// A place of the map where points may have been seen.
struct PlaceCandidate {
  std::size_t keyframe;      ///< the nearest one
  Pose2 T_keyframe_vehicle;  ///< in its xy plane, within half a step
  double score;              ///< mean likelihood of the points, [0, 1]
};

/// Searches a map, or a region of it, for the places where some points may have been seen.
/// Exhaustive: every position near a keyframe and every heading on a coarse grid. It works in
/// pieces, so that other vehicles can be served in between. A piece costs a millisecond or two. The
/// number of pieces grows with the length of street, the memory does not.
class PlaceSearch {
 public:
  /// `points` are x and y in the vehicle frame; `options` are valid.
  PlaceSearch(std::shared_ptr<const RadarMap> map, std::span<const Eigen::Vector2f> points,
              const PlaceSearchOptions& options = {});
  ~PlaceSearch();
  PlaceSearch(PlaceSearch&&) noexcept;
  PlaceSearch& operator=(PlaceSearch&&) noexcept;

  bool done() const { return next_tile_ == tiles_.size(); }
  double cell_m() const { return options_.cell_m; }

  /// Searches the next piece, some squares 16 cells wide in every heading, unless `done()`.
  void SearchOn();

  /// Up to `max_count` best places so far, best first, no two within four steps of one another.
  std::vector<PlaceCandidate> Best();

 private:
  // Of a square grid in the map's xy plane.
  struct Cell {
    std::int64_t x = 0;
    std::int64_t y = 0;
    bool operator==(const Cell& other) const { return x == other.x && y == other.y; }
    bool operator<(const Cell& other) const { return std::tie(x, y) < std::tie(other.x, other.y); }
  };
  // A heading: where each point lies from the vehicle's cell, in cells.
  struct Turned {
    double yaw_rad;
    std::vector<Eigen::Vector2i> offsets;
  };
  struct Candidate {
    Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  // in the map's xy plane
    double yaw_rad = 0.0;
    int sum = 0;  // of its likelihoods
  };
  class TileField;

  void BeginTile();
  void SearchBlock(const Cell& block);

  std::vector<Cell> CellsNearKeyframe(std::size_t keyframe, double size_m) const;
  std::vector<Cell> BlocksOf(const Cell& tile) const;
  bool IsSought(const Cell& cell, double size_m) const;
  bool IsSought(const Cell& block, double size_m, double yaw_rad) const;
  bool IsSought(double yaw_rad) const;
  std::vector<std::size_t> KeyframesAround(const Cell& tile, double margin_m) const;
  std::vector<Eigen::Vector2d> LandmarksAround(const Cell& tile) const;
  void KeepBest();
  PlaceCandidate InKeyframe(const Candidate& candidate) const;

  std::shared_ptr<const RadarMap> map_;
  PlaceSearchOptions options_;
  double block_m_;
  double tile_m_;
  double margin_m_ = 0.0;  // as far as the points reach, in whole cells
  std::vector<Turned> headings_;
  std::vector<Cell> tiles_;
  std::size_t next_tile_ = 0;
  std::unique_ptr<TileField> field_;  // of the tile that is being searched
  std::vector<Cell> blocks_;          // likewise
  std::size_t next_block_ = 0;
  std::vector<Candidate> candidates_;
  int least_sum_ = 0;  // others are better
};

}  // namespace dcloc
