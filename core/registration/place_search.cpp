#include "core/registration/place_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <numbers>

#include "core/registration/likelihood_field.h"

namespace dcloc {
namespace {

// Positions are scored a block at a time, whose rows are one vector register each; the field is
// made for a tile of blocks at a time.
constexpr int kBlock_cells = 16;
constexpr int kTile_blocks = 16;
constexpr std::size_t kMaxPoints = 150;  // enough to tell places apart; sums fit into 16 bits
static_assert(kMaxPoints * 255 <= 65535);

struct Cell {
  std::int64_t x = 0;
  std::int64_t y = 0;
  auto operator<=>(const Cell&) const = default;
};

Cell CellOf(const Eigen::Vector2d& p_m, double cell_m) {
  return {static_cast<std::int64_t>(std::floor(p_m.x() / cell_m)),
          static_cast<std::int64_t>(std::floor(p_m.y() / cell_m))};
}

// Of the map's xy plane; by tile, so that the blocks of one follow each other.
struct Block {
  Cell tile;
  Cell block;  // within the tile, in blocks
  auto operator<=>(const Block&) const = default;
};

// One heading: where each point lies from the vehicle's cell, in cells.
struct Turned {
  double yaw_rad;
  std::vector<Eigen::Vector2i> offsets;
};

struct Candidate {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  // in the map's xy plane
  double yaw_rad = 0.0;
  double score = 0.0;
};

std::vector<Eigen::Vector2f> Thinned(std::span<const Eigen::Vector2f> points) {
  const std::size_t stride =
      std::max<std::size_t>(1, (points.size() + kMaxPoints - 1) / kMaxPoints);
  std::vector<Eigen::Vector2f> thinned;
  for (std::size_t i = 0; i < points.size(); i += stride) thinned.push_back(points[i]);
  return thinned;
}

std::vector<Turned> TurnAll(std::span<const Eigen::Vector2f> points, double step_rad,
                            double cell_m) {
  const int count = static_cast<int>(std::ceil(2.0 * std::numbers::pi / step_rad));
  std::vector<Turned> headings;
  for (int i = 0; i < count; ++i) {
    Turned turned{.yaw_rad = 2.0 * std::numbers::pi * i / count, .offsets = {}};
    const Eigen::Rotation2Dd R(turned.yaw_rad);
    for (const Eigen::Vector2f& point : points) {
      // The vehicle stands at its cell's middle.
      const Eigen::Vector2d at = R * point.cast<double>() / cell_m;
      turned.offsets.emplace_back(static_cast<int>(std::floor(at.x() + 0.5)),
                                  static_cast<int>(std::floor(at.y() + 0.5)));
    }
    headings.push_back(std::move(turned));
  }
  return headings;
}

class PlaceSearch {
 public:
  PlaceSearch(const RadarMap& map, std::span<const Eigen::Vector2f> points,
              const PlaceSearchOptions& options)
      : map_(map), options_(options), points_(Thinned(points)) {
    std::vector<float> ranges;
    for (const Eigen::Vector2f& point : points_) ranges.push_back(point.norm());
    std::ranges::sort(ranges);
    // The angle that moves half of the points by less than two cells.
    const double step_rad = 2.0 * options_.cell_m / std::max(10.0F, ranges[ranges.size() / 2]);
    headings_ = TurnAll(points_, step_rad, options_.cell_m);
    margin_m_ = options_.cell_m * std::ceil(ranges.back() / options_.cell_m + 1.0);
  }

  std::vector<Candidate> Run() {
    const std::vector<Block> blocks = Blocks();
    for (auto begin = blocks.begin(); begin != blocks.end();) {
      const auto end = std::find_if(begin, blocks.end(),
                                    [&](const Block& block) { return block.tile != begin->tile; });
      SearchTile({begin, end});
      KeepBest();
      begin = end;
    }
    return std::move(candidates_);
  }

 private:
  // Those that hold a position near to a keyframe.
  std::vector<Block> Blocks() const {
    const double block_m = kBlock_cells * options_.cell_m;
    const Eigen::Vector2d reach_m = Eigen::Vector2d::Constant(options_.reach_m);
    std::vector<Block> blocks;
    for (std::size_t i = 0; i < map_.info().keyframe_count; ++i) {
      const Eigen::Vector2d p_map = map_.keyframe(i).T_map_keyframe.translation_m.head<2>();
      const Cell first = CellOf(p_map - reach_m, block_m);
      const Cell last = CellOf(p_map + reach_m, block_m);
      for (std::int64_t x = first.x; x <= last.x; ++x) {
        for (std::int64_t y = first.y; y <= last.y; ++y) {
          const Cell tile =
              CellOf(Eigen::Vector2d(static_cast<double>(x), static_cast<double>(y)), kTile_blocks);
          blocks.push_back({tile, {x - kTile_blocks * tile.x, y - kTile_blocks * tile.y}});
        }
      }
    }
    std::ranges::sort(blocks);
    const auto rest = std::ranges::unique(blocks);
    blocks.erase(rest.begin(), rest.end());
    return blocks;
  }

  void SearchTile(std::span<const Block> blocks) {
    const double tile_m = kTile_blocks * kBlock_cells * options_.cell_m;
    const Eigen::Vector2d origin_m =
        tile_m * Eigen::Vector2d(static_cast<double>(blocks.front().tile.x),
                                 static_cast<double>(blocks.front().tile.y));
    const LikelihoodField field(Landmarks(origin_m, tile_m), options_.cell_m,
                                Eigen::Vector2d::Constant(-margin_m_),
                                Eigen::Vector2d::Constant(tile_m + margin_m_));
    if (field.empty()) return;
    const Eigen::Vector2i first =
        field.CellsFrom(Eigen::Vector2d::Constant(0.5 * options_.cell_m)).cast<int>();
    for (const Block& block : blocks) {
      const Eigen::Vector2i corner(static_cast<int>(block.block.x) * kBlock_cells,
                                   static_cast<int>(block.block.y) * kBlock_cells);
      for (const Turned& turned : headings_) {
        const auto [cell, sum] = BestOfBlock(field, first + corner, turned.offsets);
        if (sum == 0) continue;
        const Eigen::Vector2d at = (corner + cell).cast<double>().array() + 0.5;
        candidates_.push_back({origin_m + options_.cell_m * at, turned.yaw_rad,
                               sum / 255.0 / static_cast<double>(points_.size())});
      }
    }
  }

  // Best first. A place has some dozens of candidates, in the blocks and headings around it.
  void KeepBest() {
    constexpr std::size_t kMaxCandidates = 2000;
    std::ranges::stable_sort(candidates_, std::greater<>(), &Candidate::score);
    if (candidates_.size() > kMaxCandidates) candidates_.resize(kMaxCandidates);
  }

  // Positions in the tile's frame, as far as the points reach from anywhere in the tile.
  std::vector<Eigen::Vector2d> Landmarks(const Eigen::Vector2d& origin_m, double tile_m) const {
    // Landmarks lie no further from their keyframe than this, or they are too few to matter.
    constexpr double kKeyframeReach_m = 100.0;
    const Eigen::Vector2d middle_m = origin_m.array() + 0.5 * tile_m;
    const double radius_m = std::numbers::sqrt2 * (0.5 * tile_m + margin_m_) + kKeyframeReach_m;
    std::vector<Eigen::Vector2d> landmarks;
    for (const std::size_t index :
         map_.KeyframesWithin({middle_m.x(), middle_m.y(), 0.0}, radius_m)) {
      const Keyframe keyframe = map_.keyframe(index);
      const Eigen::Matrix3d R = keyframe.T_map_keyframe.Rotation();
      for (const MapPoint& point : keyframe.points) {
        const Eigen::Vector3d p_map = R * Eigen::Vector3d(point.x_m, point.y_m, point.z_m) +
                                      keyframe.T_map_keyframe.translation_m;
        landmarks.emplace_back(p_map.head<2>() - origin_m);
      }
    }
    return landmarks;
  }

  struct BestCell {
    Eigen::Vector2i cell;  // in the block
    int sum;
  };

  // `corner` is the block's first cell in the field.
  static BestCell BestOfBlock(const LikelihoodField& field, const Eigen::Vector2i& corner,
                              std::span<const Eigen::Vector2i> offsets) {
    std::array<std::uint16_t, std::size_t{kBlock_cells} * kBlock_cells> sums{};
    for (const Eigen::Vector2i& offset : offsets) {
      const std::uint8_t* likelihoods = field.At(corner + offset);
      for (std::size_t row = 0; row < kBlock_cells; ++row, likelihoods += field.columns()) {
        std::uint16_t* const sums_of_row = &sums[row * kBlock_cells];
        for (std::size_t column = 0; column < kBlock_cells; ++column) {
          sums_of_row[column] =
              static_cast<std::uint16_t>(sums_of_row[column] + likelihoods[column]);
        }
      }
    }
    const auto best = std::ranges::max_element(sums);
    const auto number = static_cast<int>(best - sums.begin());
    return {{number % kBlock_cells, number / kBlock_cells}, *best};
  }

  const RadarMap& map_;
  PlaceSearchOptions options_;
  std::vector<Eigen::Vector2f> points_;
  std::vector<Turned> headings_;
  double margin_m_ = 0.0;  // as far as the points reach, in whole cells
  std::vector<Candidate> candidates_;
};

PlaceHypothesis InKeyframe(const RadarMap& map, const Candidate& candidate, double reach_m) {
  Pose3 T_map_vehicle =
      Embed(Pose2{.translation_m = candidate.position_m, .yaw_rad = candidate.yaw_rad});
  // A block reaches further than the keyframe that it is searched for, but not by more than itself.
  const std::size_t keyframe = *map.NearestKeyframe(T_map_vehicle.translation_m, reach_m);
  const Pose3 T_map_keyframe = map.keyframe(keyframe).T_map_keyframe;
  T_map_vehicle.translation_m.z() = T_map_keyframe.translation_m.z();
  return {keyframe, Flatten(T_map_keyframe.Inverse() * T_map_vehicle), candidate.score};
}

}  // namespace

std::vector<PlaceHypothesis> SearchPlaces(const RadarMap& map,
                                          std::span<const Eigen::Vector2f> points,
                                          const PlaceSearchOptions& options) {
  if (points.empty()) return {};
  const double apart_m = 4.0 * options.cell_m;
  constexpr double kApart_rad = 0.25;
  std::vector<Candidate> kept;
  for (const Candidate& candidate : PlaceSearch(map, points, options).Run()) {
    if (kept.size() == static_cast<std::size_t>(options.max_count)) break;
    const bool seen = std::ranges::any_of(kept, [&](const Candidate& other) {
      return (candidate.position_m - other.position_m).norm() < apart_m &&
             std::abs(WrapAngle(candidate.yaw_rad - other.yaw_rad)) < kApart_rad;
    });
    if (!seen) kept.push_back(candidate);
  }
  const double reach_m =
      std::numbers::sqrt2 * (options.reach_m + kBlock_cells * options.cell_m + 1.0);
  std::vector<PlaceHypothesis> places;
  for (const Candidate& candidate : kept) places.push_back(InKeyframe(map, candidate, reach_m));
  return places;
}

}  // namespace dcloc
