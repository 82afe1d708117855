#include "core/map/keyframe_index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

// Clamped, so that any query is defined; positions in a file are far within (kMaxLocal_m).
std::int32_t CellOf(double coordinate_m, double cell_m) {
  return static_cast<std::int32_t>(std::clamp(std::floor(coordinate_m / cell_m), -2e9, 2e9));
}

IndexRecord RecordOf(std::span<const KeyframeRecord> keyframes, std::uint32_t keyframe,
                     double cell_m) {
  const auto& position = keyframes[keyframe].translation_local_m;
  return {CellOf(position[0], cell_m), CellOf(position[1], cell_m), keyframe};
}

bool Before(const IndexRecord& a, const IndexRecord& b) {
  return std::tie(a.cell_x, a.cell_y, a.keyframe) < std::tie(b.cell_x, b.cell_y, b.keyframe);
}

Eigen::Vector2d PositionOf(const KeyframeRecord& keyframe) {
  return {keyframe.translation_local_m[0], keyframe.translation_local_m[1]};
}

}  // namespace

std::vector<IndexRecord> MakeIndex(std::span<const KeyframeRecord> keyframes, double cell_m) {
  std::vector<IndexRecord> index;
  index.reserve(keyframes.size());
  for (std::uint32_t i = 0; i < keyframes.size(); ++i) {
    index.push_back(RecordOf(keyframes, i, cell_m));
  }
  std::ranges::sort(index, Before);
  return index;
}

absl::Status CheckIndex(std::span<const IndexRecord> index,
                        std::span<const KeyframeRecord> keyframes, double cell_m) {
  if (index.size() != keyframes.size()) {
    return absl::DataLossError(
        absl::StrFormat("index: %d records for %d keyframes", index.size(), keyframes.size()));
  }
  for (std::size_t i = 0; i < index.size(); ++i) {
    const IndexRecord& record = index[i];
    if (record.keyframe >= keyframes.size()) {
      return absl::DataLossError(absl::StrFormat("index record %d: keyframe is %d of %d", i,
                                                 record.keyframe, keyframes.size()));
    }
    const IndexRecord expected = RecordOf(keyframes, record.keyframe, cell_m);
    if (record.cell_x != expected.cell_x || record.cell_y != expected.cell_y) {
      return absl::DataLossError(absl::StrFormat(
          "index record %d: cell is (%d, %d); keyframe %d lies in (%d, %d)", i, record.cell_x,
          record.cell_y, record.keyframe, expected.cell_x, expected.cell_y));
    }
    // Strictly ascending: with the cells right, each keyframe is there exactly once.
    if (i > 0 && !Before(index[i - 1], record)) {
      return absl::DataLossError(absl::StrFormat("index record %d: out of order", i));
    }
  }
  return absl::OkStatus();
}

KeyframeIndex::KeyframeIndex(std::span<const IndexRecord> index,
                             std::span<const KeyframeRecord> keyframes, double cell_m)
    : index_(index), keyframes_(keyframes), cell_m_(cell_m) {
  if (keyframes.empty()) return;
  min_m_ = max_m_ = PositionOf(keyframes.front());
  for (const KeyframeRecord& keyframe : keyframes) {
    min_m_ = min_m_.cwiseMin(PositionOf(keyframe));
    max_m_ = max_m_.cwiseMax(PositionOf(keyframe));
  }
}

template <typename Visit>
void KeyframeIndex::ForEachWithin(const Eigen::Vector2d& p_local_m, double radius_m,
                                  const Visit& visit) const {
  if (!p_local_m.allFinite() || !(radius_m >= 0.0)) return;
  const std::int32_t min_x = CellOf(p_local_m.x() - radius_m, cell_m_);
  const std::int32_t max_x = CellOf(p_local_m.x() + radius_m, cell_m_);
  const std::int32_t min_y = CellOf(p_local_m.y() - radius_m, cell_m_);
  const std::int32_t max_y = CellOf(p_local_m.y() + radius_m, cell_m_);

  auto record = index_.begin();
  const auto skip_to = [&](std::int32_t cell_x, std::int32_t cell_y) {
    record = std::lower_bound(record, index_.end(), IndexRecord{cell_x, cell_y, 0}, Before);
  };
  skip_to(min_x, min_y);
  while (record != index_.end() && record->cell_x <= max_x) {
    if (record->cell_y < min_y) {
      skip_to(record->cell_x, min_y);
    } else if (record->cell_y > max_y) {
      skip_to(record->cell_x + 1, min_y);
    } else {
      const double squared_m2 =
          (PositionOf(keyframes_[record->keyframe]) - p_local_m).squaredNorm();
      if (squared_m2 <= radius_m * radius_m) visit(record->keyframe, squared_m2);
      ++record;
    }
  }
}

std::vector<std::size_t> KeyframeIndex::Within(const Eigen::Vector2d& p_local_m,
                                               double radius_m) const {
  std::vector<std::size_t> found;
  Within(p_local_m, radius_m, found);
  return found;
}

void KeyframeIndex::Within(const Eigen::Vector2d& p_local_m, double radius_m,
                           std::vector<std::size_t>& found) const {
  found.clear();
  ForEachWithin(p_local_m, radius_m,
                [&](std::uint32_t keyframe, double) { found.push_back(keyframe); });
  std::ranges::sort(found);
}

std::optional<std::size_t> KeyframeIndex::Nearest(const Eigen::Vector2d& p_local_m,
                                                  double max_distance_m) const {
  if (keyframes_.empty() || !p_local_m.allFinite() || !(max_distance_m >= 0.0)) return std::nullopt;
  // Everything lies in a box: no nearer than its near side, no further than its far corner.
  const double gap_m = (p_local_m - p_local_m.cwiseMax(min_m_).cwiseMin(max_m_)).norm();
  const double reach_m =
      (p_local_m - min_m_).cwiseAbs().cwiseMax((p_local_m - max_m_).cwiseAbs()).norm();
  const double limit_m = std::min(max_distance_m, reach_m * (1.0 + 1e-9));
  for (double radius_m = gap_m + cell_m_;; radius_m *= 2.0) {
    constexpr std::pair kNone(std::numeric_limits<double>::infinity(), std::uint32_t{0});
    std::pair<double, std::uint32_t> nearest = kNone;
    ForEachWithin(p_local_m, std::min(radius_m, limit_m),
                  [&](std::uint32_t keyframe, double squared_m2) {
                    nearest = std::min(nearest, {squared_m2, keyframe});
                  });
    if (nearest != kNone) return nearest.second;
    if (!(radius_m < limit_m)) return std::nullopt;
  }
}

}  // namespace dcloc
