#include "core/registration/correlative_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "core/registration/search_grid.h"

namespace dcloc {
namespace {

double MedianRange(std::span<const Eigen::Vector2f> points) {
  std::vector<float> ranges;
  for (const Eigen::Vector2f& point : points) ranges.push_back(point.norm());
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  return *middle;
}

// The positions of a window, at one heading after the other: sums over points of the likelihoods
// that each finds there. Positions are whole cells apart, so that a point's likelihoods at
// neighbouring positions are neighbours in the field: a row of them is added at once.
class WindowSums {
 public:
  explicit WindowSums(int shifts)
      : shifts_(shifts), side_(2 * shifts + 1), sums_(Area()), chunk_(Area()) {}

  /// For `points` at `pose`, the window's centre; row by row, x fastest.
  const std::vector<std::uint32_t>& At(std::span<const Eigen::Vector2f> points,
                                       const LikelihoodField& field, const Pose2& pose) {
    constexpr std::size_t kChunk = 256;  // of so many points the sums fit into 16 bits
    static_assert(kChunk * 255 <= 65535);
    const Eigen::Matrix2d R = pose.Rotation();
    std::ranges::fill(sums_, 0);
    for (std::size_t begin = 0; begin < points.size(); begin += kChunk) {
      std::ranges::fill(chunk_, 0);
      for (const Eigen::Vector2f& point :
           points.subspan(begin, std::min(kChunk, points.size() - begin))) {
        const Eigen::Vector2d at = field.CellsFrom(R * point.cast<double>() + pose.translation_m);
        // Written so that what is not a number, and what no number of cells reaches, is left out.
        if (at.cwiseAbs().maxCoeff() <= kMaxCells) Add(field, at.array().floor().cast<int>());
      }
      for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += chunk_[i];
    }
    return sums_;
  }

 private:
  static constexpr double kMaxCells = 1e8;

  std::size_t Area() const {
    return static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_);
  }

  // `cell` is the point's at the window's centre.
  void Add(const LikelihoodField& field, const Eigen::Vector2i& cell) {
    const Eigen::Vector2i first = cell.array() - shifts_;  // at the window's first position
    const int column_begin = std::max(0, -first.x());
    const int column_end = std::min(side_, field.columns() - first.x());
    const int row_begin = std::max(0, -first.y());
    const int row_end = std::min(side_, field.rows() - first.y());
    if (column_begin >= column_end) return;
    const auto count = static_cast<std::size_t>(column_end - column_begin);
    for (int row = row_begin; row < row_end; ++row) {
      const std::uint8_t* const from = field.At(first + Eigen::Vector2i(column_begin, row));
      std::uint16_t* const to =
          &chunk_[static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) +
                  static_cast<std::size_t>(column_begin)];
      for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<std::uint16_t>(to[i] + from[i]);
    }
  }

  int shifts_;
  int side_;
  std::vector<std::uint32_t> sums_;
  std::vector<std::uint16_t> chunk_;
};

// A pose of the window, and how good it is.
struct Entry {
  std::uint32_t sum;
  std::uint32_t number;  // by turn, row and column

  // Of equally good ones the first.
  bool operator<(const Entry& other) const {
    return sum != other.sum ? sum < other.sum : number > other.number;
  }
};

// The best `count` of all entries that are added. A window has millions; these stay in the cache.
class BestEntries {
 public:
  explicit BestEntries(std::size_t count) : count_(count) { entries_.reserve(2 * count); }

  void Add(const Entry& entry) {
    if (!(beaten_ < entry)) return;
    entries_.push_back(entry);
    if (entries_.size() == 2 * count_) Prune();
  }

  /// The best first.
  std::span<const Entry> Sorted() {
    std::ranges::sort(entries_, [](const Entry& a, const Entry& b) { return b < a; });
    return std::span(entries_).first(std::min(count_, entries_.size()));
  }

 private:
  void Prune() {
    const auto last = entries_.begin() + static_cast<std::ptrdiff_t>(count_) - 1;
    std::ranges::nth_element(entries_, last, [](const Entry& a, const Entry& b) { return b < a; });
    beaten_ = *last;
    entries_.resize(count_);
  }

  std::size_t count_;
  std::vector<Entry> entries_;
  // `count_` entries are at least as good as this one.
  Entry beaten_{.sum = 0, .number = std::numeric_limits<std::uint32_t>::max()};
};

// At most so many poses of a window are of one peak: a cube around its best one. Its corners make
// up for headings that a whole turn repeats.
constexpr std::size_t kPosesOfPeak = [] {
  constexpr auto kSide = 2 * static_cast<std::size_t>(kPeakWidth_cells) + 1;
  return kSide * kSide * kSide;
}();

}  // namespace

std::vector<PoseCandidate> CorrelativeSearch(std::span<const Eigen::Vector2f> points,  // METHOD 5
                                             const LikelihoodField& field,
                                             const SearchWindow& window, int max_count) {
  if (points.empty() || field.empty() || max_count <= 0) return {};
  const double step_m = field.cell_m();
  const double step_rad = HeadingStep_rad(step_m, MedianRange(points));
  const double half_rad = std::min(window.rotation_rad, std::numbers::pi);
  const int turns = static_cast<int>(std::ceil(half_rad / step_rad));
  const int shifts = static_cast<int>(std::ceil(window.translation_m / step_m));
  const auto turned = [&](int turn) {
    Pose2 pose = window.centre_local_vehicle;
    pose.yaw_rad = WrapAngle(pose.yaw_rad + turn * step_rad);
    return pose;
  };

  WindowSums sums(shifts);
  // Before the last peak is found, at most all poses of the others have come.
  BestEntries entries(kPosesOfPeak * static_cast<std::size_t>(max_count));
  std::uint32_t number = 0;
  for (int turn = -turns; turn <= turns; ++turn) {
    for (const std::uint32_t sum : sums.At(points, field, turned(turn))) {
      entries.Add({.sum = sum, .number = number++});
    }
  }

  const int side = 2 * shifts + 1;
  std::vector<PoseCandidate> best;
  for (const Entry& entry : entries.Sorted()) {
    const auto at = static_cast<int>(entry.number);
    PoseCandidate candidate{.T_local_vehicle = turned(at / (side * side) - turns),
                            .score = entry.sum / (255.0 * static_cast<double>(points.size()))};
    candidate.T_local_vehicle.translation_m +=
        step_m * Eigen::Vector2d(at % side - shifts, at / side % side - shifts);
    const bool seen = std::any_of(best.begin(), best.end(), [&](const PoseCandidate& kept) {
      const Pose2 apart = kept.T_local_vehicle.Inverse() * candidate.T_local_vehicle;
      return apart.translation_m.norm() < kPeakWidth_cells * step_m &&
             std::abs(apart.yaw_rad) < kPeakWidth_cells * step_rad;
    });
    if (seen) continue;
    best.push_back(candidate);
    if (best.size() == static_cast<std::size_t>(max_count)) break;
  }
  return best;
}

}  // namespace dcloc
