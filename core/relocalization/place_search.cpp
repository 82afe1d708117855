#include "core/relocalization/place_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/geometry/thinning.h"
#include "core/registration/likelihood_field.h"
#include "core/registration/search_grid.h"

namespace dcloc {
namespace {

// Positions are scored a block at a time, whose rows are one vector register each; the field is
// made for a tile of blocks at a time.
constexpr int kBlock_cells = 16;
constexpr int kTile_blocks = 16;
constexpr std::size_t kPieceSums = 2048;  // blocks times headings, worth a millisecond or so
// Enough points to tell places apart; a multiple of kAtOnce.
constexpr std::size_t kMaxPoints = 152;
// Likelihoods are added as bytes, so many at a time as a byte holds, and then as shorts.
constexpr std::size_t kAtOnce = 8;
constexpr int kShift = 3;
constexpr int kMostLikely = 255 >> kShift;
static_assert(kAtOnce * kMostLikely <= 255);
static_assert(kMaxPoints * kMostLikely <= 32767);
constexpr std::size_t kMaxCandidates = 2000;  // before they are thinned to the best

// One point a cell, as the detections of one scatterer in several scans say one thing, and of those
// each n-th.
std::vector<Eigen::Vector2f> OnePerCell(std::span<const Eigen::Vector2f> points, double cell_m) {
  struct Placed {
    int x, y;
    std::size_t index;
  };
  std::vector<Placed> placed;
  placed.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d cell = (points[i].cast<double>() / cell_m).array().floor();
    placed.push_back({static_cast<int>(cell.x()), static_cast<int>(cell.y()), i});
  }
  std::ranges::stable_sort(placed, {}, [](const Placed& p) { return std::pair(p.x, p.y); });
  const auto doubles =
      std::unique(placed.begin(), placed.end(),
                  [](const Placed& a, const Placed& b) { return a.x == b.x && a.y == b.y; });
  placed.erase(doubles, placed.end());
  std::ranges::sort(placed, {}, &Placed::index);
  const std::size_t step = StepToKeep(kMaxPoints, placed.size());
  std::vector<Eigen::Vector2f> chosen;
  chosen.reserve(placed.size() / step + 1);
  for (std::size_t i = 0; i < placed.size(); i += step) chosen.push_back(points[placed[i].index]);
  return chosen;
}

// For each position of a block, row by row.
using Sums = std::array<std::int16_t, std::size_t{kBlock_cells} * kBlock_cells>;

// Adds what `likelihoods` say, whose rows are `columns` apart.
template <std::size_t... kIndices>
void AddLikelihoods(std::array<const std::uint8_t*, sizeof...(kIndices)> likelihoods, int columns,
                    std::index_sequence<kIndices...> /*indices*/, Sums& sums) {
  for (std::size_t row = 0; row < kBlock_cells; ++row) {
    std::int16_t* const of_row = &sums[row * kBlock_cells];
    for (std::size_t column = 0; column < kBlock_cells; ++column) {
      const auto sum = static_cast<std::uint8_t>((... + likelihoods[kIndices][column]));
      of_row[column] = static_cast<std::int16_t>(of_row[column] + sum);
    }
    for (const std::uint8_t*& one : likelihoods) one += columns;
  }
}

}  // namespace

// The likelihoods around a tile, each worth so little that some add up to a byte.
class PlaceSearch::TileField {
 public:
  TileField(const LikelihoodField& field, const Eigen::Vector2i& first)
      : first_(first),
        columns_(field.columns()),
        cells_(field.At({0, 0}),
               field.At({0, 0}) + static_cast<std::ptrdiff_t>(field.columns()) * field.rows()) {
    for (std::uint8_t& cell : cells_) cell = static_cast<std::uint8_t>(cell >> kShift);
  }

  // Sums over the points, for each position of the block whose first cell in the tile is `corner`.
  Sums SumsOf(const Eigen::Vector2i& corner, std::span<const Eigen::Vector2i> offsets) const {
    Sums sums{};
    std::size_t i = 0;
    for (; i + kAtOnce <= offsets.size(); i += kAtOnce) {
      std::array<const std::uint8_t*, kAtOnce> likelihoods;
      for (std::size_t j = 0; j < kAtOnce; ++j) likelihoods[j] = At(corner + offsets[i + j]);
      AddLikelihoods(likelihoods, columns_, std::make_index_sequence<kAtOnce>(), sums);
    }
    for (; i < offsets.size(); ++i) {
      AddLikelihoods(std::array{At(corner + offsets[i])}, columns_, std::make_index_sequence<1>(),
                     sums);
    }
    return sums;
  }

 private:
  const std::uint8_t* At(const Eigen::Vector2i& cell) const {
    const Eigen::Vector2i at = first_ + cell;
    return &cells_[static_cast<std::size_t>(at.y()) * static_cast<std::size_t>(columns_) +
                   static_cast<std::size_t>(at.x())];
  }

  Eigen::Vector2i first_;  // the tile's
  int columns_;
  std::vector<std::uint8_t> cells_;
};

namespace {

double DistanceToBox(const Eigen::Vector2d& p, const Eigen::Vector2d& min_m,
                     const Eigen::Vector2d& max_m) {
  return (p.cwiseMax(min_m).cwiseMin(max_m) - p).norm();
}

// Of the vehicle now.
bool HoldsHeading(const SearchRegion& region, double yaw_rad) {
  return std::abs(WrapAngle(yaw_rad - region.T_then_now.yaw_rad - region.yaw_rad)) <=
         region.max_yaw_offset_rad;
}

// Where the vehicle is now, if it was at the region's centre and now looks there.
Eigen::Vector2d CentreNow(const SearchRegion& region, double yaw_rad) {
  return region.centre_m +
         Eigen::Rotation2Dd(yaw_rad - region.T_then_now.yaw_rad) * region.T_then_now.translation_m;
}

template <typename T>
void SortUnique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

bool SearchRegion::Contains(const Pose2& T_map_vehicle) const {
  return MayContain(T_map_vehicle.translation_m, T_map_vehicle.translation_m,
                    T_map_vehicle.yaw_rad) &&
         HoldsHeading(*this, T_map_vehicle.yaw_rad);
}

bool SearchRegion::MayContain(const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m,
                              double yaw_now_rad) const {
  return DistanceToBox(CentreNow(*this, yaw_now_rad), min_m, max_m) <= radius_m;
}

std::span<const OptionField<PlaceSearchOptions>> FieldsOf(const PlaceSearchOptions& /*options*/) {
  using O = PlaceSearchOptions;
  static constexpr OptionField<O> kFields[] = {
      {"cell_m", &O::cell_m, 0.1, 10},
      {"max_keyframe_distance_m", &O::max_keyframe_distance_m, 0, 1000,
       "only the block of cells around each keyframe is searched"},
      {"max_count", &O::max_count, 1, 10'000},
  };
  return kFields;
}

absl::Status Validate(const PlaceSearchOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

PlaceSearch::PlaceSearch(std::shared_ptr<const RadarMap> map,
                         std::span<const Eigen::Vector2f> points, const PlaceSearchOptions& options)
    : map_(std::move(map)),
      options_(options),
      block_m_(kBlock_cells * options.cell_m),
      tile_m_(kTile_blocks * block_m_) {
  if (points.empty()) return;
  const std::vector<Eigen::Vector2f> chosen = OnePerCell(points, options.cell_m);
  std::vector<float> ranges;
  ranges.reserve(chosen.size());
  for (const Eigen::Vector2f& point : chosen) ranges.push_back(point.norm());
  std::ranges::sort(ranges);
  margin_m_ = options_.cell_m * std::ceil(ranges.back() / options_.cell_m + 1.0);

  const double step_rad = HeadingStep_rad(options_.cell_m, ranges[ranges.size() / 2]);
  const int count = static_cast<int>(std::ceil(2.0 * std::numbers::pi / step_rad));
  for (int i = 0; i < count; ++i) {
    if (!IsSought(2.0 * std::numbers::pi * i / count)) continue;
    Turned turned{.yaw_rad = 2.0 * std::numbers::pi * i / count, .offsets = {}};
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(turned.yaw_rad).toRotationMatrix();
    for (const Eigen::Vector2f& point : chosen) {
      // The vehicle stands at its cell's middle.
      const Eigen::Vector2d at = R * point.cast<double>() / options_.cell_m;
      turned.offsets.emplace_back((at.array() + 0.5).floor().cast<int>());
    }
    headings_.push_back(std::move(turned));
  }
  for (std::size_t i = 0; i < map_->info().keyframe_count; ++i) {
    for (const Cell& tile : CellsNearKeyframe(i, tile_m_)) {
      if (IsSought(tile, tile_m_)) tiles_.push_back(tile);
    }
  }
  SortUnique(tiles_);
}

// Here the field's size is known.
PlaceSearch::~PlaceSearch() = default;
PlaceSearch::PlaceSearch(PlaceSearch&&) noexcept = default;
PlaceSearch& PlaceSearch::operator=(PlaceSearch&&) noexcept = default;

void PlaceSearch::SearchOn() {
  if (done()) return;
  if (!field_) BeginTile();
  const std::size_t count = 1 + kPieceSums / std::max<std::size_t>(1, headings_.size());
  const std::size_t end = std::min(blocks_.size(), next_block_ + count);
  while (next_block_ < end) SearchBlock(blocks_[next_block_++]);
  if (next_block_ < blocks_.size()) return;
  field_.reset();
  ++next_tile_;
}

void PlaceSearch::BeginTile() {
  const Cell& tile = tiles_[next_tile_];
  const LikelihoodField field(LandmarksAround(tile), options_.cell_m,
                              Eigen::Vector2d::Constant(-margin_m_),
                              Eigen::Vector2d::Constant(tile_m_ + margin_m_));
  field_ = std::make_unique<TileField>(
      field, field.CellsFrom(Eigen::Vector2d::Constant(0.5 * options_.cell_m)).cast<int>());
  blocks_ = BlocksOf(tile);
  next_block_ = 0;
}

// The best position of the block in each heading.
void PlaceSearch::SearchBlock(const Cell& block) {
  const Cell& tile = tiles_[next_tile_];
  const Eigen::Vector2i corner =
      kBlock_cells * Eigen::Vector2i(static_cast<int>(block.x - kTile_blocks * tile.x),
                                     static_cast<int>(block.y - kTile_blocks * tile.y));
  const Eigen::Vector2d first_m =
      block_m_ * Eigen::Vector2d(static_cast<double>(block.x), static_cast<double>(block.y));
  for (const Turned& turned : headings_) {
    if (!IsSought(block, block_m_, turned.yaw_rad)) continue;
    const Sums sums = field_->SumsOf(corner, turned.offsets);
    std::int16_t best = 0;
    for (const std::int16_t sum : sums) best = std::max(best, sum);
    if (best <= least_sum_) continue;
    const auto number = static_cast<int>(std::ranges::find(sums, best) - sums.begin());
    const Eigen::Vector2d cell(number % kBlock_cells, number / kBlock_cells);
    candidates_.push_back(
        {first_m + options_.cell_m * (cell.array() + 0.5).matrix(), turned.yaw_rad, best});
  }
  if (candidates_.size() >= 2 * kMaxCandidates) KeepBest();
}

std::vector<PlaceCandidate> PlaceSearch::Best() {
  KeepBest();
  const double apart_m = kPeakWidth_cells * options_.cell_m;
  constexpr double kApart_rad = 0.25;  // by which a point at 16 m moves by four cells of 1 m
  std::vector<Candidate> kept;
  for (const Candidate& candidate : candidates_) {
    if (kept.size() == static_cast<std::size_t>(options_.max_count)) break;
    const bool seen = std::ranges::any_of(kept, [&](const Candidate& other) {
      return (candidate.position_m - other.position_m).norm() < apart_m &&
             std::abs(WrapAngle(candidate.yaw_rad - other.yaw_rad)) < kApart_rad;
    });
    if (!seen) kept.push_back(candidate);
  }
  std::vector<PlaceCandidate> places;
  places.reserve(kept.size());
  for (const Candidate& candidate : kept) places.push_back(InKeyframe(candidate));
  return places;
}

// Cells of `size_m` that hold a position near to the keyframe.
std::vector<PlaceSearch::Cell> PlaceSearch::CellsNearKeyframe(std::size_t keyframe,
                                                              double size_m) const {
  const Eigen::Array2d p_map = map_->keyframe(keyframe).T_map_keyframe.translation_m.head<2>();
  using Place = Eigen::Array<std::int64_t, 2, 1>;
  const Place first =
      ((p_map - options_.max_keyframe_distance_m) / size_m).floor().cast<std::int64_t>();
  const Place last =
      ((p_map + options_.max_keyframe_distance_m) / size_m).floor().cast<std::int64_t>();
  std::vector<Cell> cells;
  for (std::int64_t x = first.x(); x <= last.x(); ++x) {
    for (std::int64_t y = first.y(); y <= last.y(); ++y) cells.push_back({x, y});
  }
  return cells;
}

// The blocks of the tile that hold a position near to a keyframe.
std::vector<PlaceSearch::Cell> PlaceSearch::BlocksOf(const Cell& tile) const {
  std::vector<Cell> blocks;
  for (const std::size_t keyframe : KeyframesAround(tile, options_.max_keyframe_distance_m)) {
    for (const Cell& block : CellsNearKeyframe(keyframe, block_m_)) {
      // Shifts round down for negative cells too.
      static_assert(kTile_blocks == 1 << 4);
      if (Cell{block.x >> 4, block.y >> 4} == tile && IsSought(block, block_m_)) {
        blocks.push_back(block);
      }
    }
  }
  SortUnique(blocks);
  return blocks;
}

// Whatever the heading.
bool PlaceSearch::IsSought(const Cell& cell, double size_m) const {
  if (!options_.region) return true;
  const SearchRegion& region = *options_.region;
  const Eigen::Vector2d first_m =
      size_m * Eigen::Vector2d(static_cast<double>(cell.x), static_cast<double>(cell.y));
  return DistanceToBox(region.centre_m, first_m, first_m + Eigen::Vector2d::Constant(size_m)) <=
         region.radius_m + region.T_then_now.translation_m.norm();
}

bool PlaceSearch::IsSought(const Cell& block, double size_m, double yaw_rad) const {
  const Eigen::Vector2d first_m =
      size_m * Eigen::Vector2d(static_cast<double>(block.x), static_cast<double>(block.y));
  return !options_.region ||
         options_.region->MayContain(first_m, first_m + Eigen::Vector2d::Constant(size_m), yaw_rad);
}

bool PlaceSearch::IsSought(double yaw_rad) const {
  return !options_.region || HoldsHeading(*options_.region, yaw_rad);
}

std::vector<std::size_t> PlaceSearch::KeyframesAround(const Cell& tile, double margin_m) const {
  const Eigen::Vector3d middle_m(tile_m_ * (static_cast<double>(tile.x) + 0.5),
                                 tile_m_ * (static_cast<double>(tile.y) + 0.5), 0.0);
  return map_->KeyframesWithin(middle_m, std::numbers::sqrt2 * (0.5 * tile_m_ + margin_m));
}

// Positions in the tile's frame, as far as the points reach from anywhere in the tile.
std::vector<Eigen::Vector2d> PlaceSearch::LandmarksAround(const Cell& tile) const {
  // Landmarks lie no further from their keyframe than this, or they are too few to matter.
  constexpr double kKeyframeReach_m = 100.0;
  const Eigen::Vector2d origin_m =
      tile_m_ * Eigen::Vector2d(static_cast<double>(tile.x), static_cast<double>(tile.y));
  std::vector<Eigen::Vector2d> landmarks;
  for (const std::size_t index : KeyframesAround(tile, margin_m_ + kKeyframeReach_m)) {
    const Keyframe keyframe = map_->keyframe(index);
    const Eigen::Matrix<double, 2, 3> R = keyframe.T_map_keyframe.Rotation().topRows<2>();
    const Eigen::Vector2d t = keyframe.T_map_keyframe.translation_m.head<2>() - origin_m;
    for (const MapPoint& point : keyframe.points) {
      landmarks.emplace_back(R * Eigen::Vector3d(point.x_m, point.y_m, point.z_m) + t);
    }
  }
  return landmarks;
}

// A place has some dozens of candidates, in the blocks and headings around it.
void PlaceSearch::KeepBest() {
  std::ranges::stable_sort(candidates_, std::greater<>(), &Candidate::sum);
  if (candidates_.size() < kMaxCandidates) return;
  candidates_.resize(kMaxCandidates);
  least_sum_ = candidates_.back().sum;
}

PlaceCandidate PlaceSearch::InKeyframe(const Candidate& candidate) const {
  Pose3 T_map_vehicle =
      Embed(Pose2{.translation_m = candidate.position_m, .yaw_rad = candidate.yaw_rad});
  // The keyframe that the block was searched for lies no further from it than this.
  const double reach_m =
      std::numbers::sqrt2 * (options_.max_keyframe_distance_m + block_m_ + options_.cell_m);
  const std::size_t keyframe = *map_->NearestKeyframe(T_map_vehicle.translation_m, reach_m);
  const Pose3 T_map_keyframe = map_->keyframe(keyframe).T_map_keyframe;
  T_map_vehicle.translation_m.z() = T_map_keyframe.translation_m.z();
  const double score = candidate.sum / (static_cast<double>(kMostLikely) *
                                        static_cast<double>(headings_.front().offsets.size()));
  return {keyframe, Flatten(T_map_keyframe.Inverse() * T_map_vehicle), score};
}

}  // namespace dcloc
