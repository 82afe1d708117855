#include "core/update/lateral_rows.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/update/keyframe_grid.h"

namespace dcloc {
namespace {

constexpr double kRow_m = 0.25;
constexpr double kSegment_m = 100.0;
// How far rows tell of one another, to the side and along the way.
constexpr double kOffsetSigma_m = 0.4;
constexpr double kAlongSigma_m = 200.0;
constexpr int kRowsBeside = 4;
constexpr int kSegmentsBeside = 4;
// Without votes a twentieth comes and goes, as if two had voted.
constexpr double kPriorVotes = 2.0;
constexpr double kPriorShare = 0.05;

double Weight(double distance_m, double sigma_m) {
  return std::exp(-0.5 * distance_m * distance_m / (sigma_m * sigma_m));
}

std::vector<int> Segments(std::span<const Pose3> T_local_keyframes) {
  std::vector<int> segments;
  double at_m = 0.0;
  const Pose3* last = &T_local_keyframes.front();
  for (const Pose3& T_local_keyframe : T_local_keyframes) {
    at_m += (T_local_keyframe.translation_m - last->translation_m).head<2>().norm();
    segments.push_back(static_cast<int>(at_m / kSegment_m));
    last = &T_local_keyframe;
  }
  return segments;
}

/// How far to the left of the way `place_m` lies at a keyframe.
double Offset_m(const Pose3& T_local_keyframe, const Eigen::Vector2d& place_m) {
  const Eigen::Vector2d ahead = (T_local_keyframe.rotation * Eigen::Vector3d::UnitX()).head<2>();
  const Eigen::Vector2d there_m = place_m - T_local_keyframe.translation_m.head<2>();
  return (ahead.x() * there_m.y() - ahead.y() * there_m.x()) / ahead.norm();
}

}  // namespace

LateralRows::LateralRows(std::span<const Pose3> T_local_keyframes,
                         std::span<const Eigen::Vector2d> places_m) {
  const std::vector<int> segments = Segments(T_local_keyframes);
  const KeyframeGrid grid(T_local_keyframes);
  for (const Eigen::Vector2d& place_m : places_m) {
    const std::size_t keyframe = grid.Nearest(place_m);
    const double offset_m = Offset_m(T_local_keyframes[keyframe], place_m);
    row_of_.emplace_back(segments[keyframe], static_cast<int>(std::floor(offset_m / kRow_m)));
  }
}

void LateralRows::Tally::Add(double weight, const RowVote& vote) {
  intermittent += weight * vote.intermittent;
  lasts += weight * vote.lasts;
  if (vote.only_witness) intermittent_by[*vote.only_witness] += weight * vote.intermittent;
}

void LateralRows::Tally::Add(double weight, const Tally& other) {
  intermittent += weight * other.intermittent;
  lasts += weight * other.lasts;
  for (const auto& [witness, votes] : other.intermittent_by) {
    intermittent_by[witness] += weight * votes;
  }
}

double LateralRows::Tally::Share() const {
  double most = 0.0;
  for (const auto& [witness, votes] : intermittent_by) most = std::max(most, votes);
  const double witnessed = std::max(0.0, intermittent - most);
  return (kPriorVotes * kPriorShare + witnessed) / (kPriorVotes + witnessed + lasts);
}

LateralRows::Tally LateralRows::Around(const Row& row, const std::map<Row, Tally>& rows) {
  Tally around;
  const auto& [row_segment, row_offset] = row;
  for (int segment = -kSegmentsBeside; segment <= kSegmentsBeside; ++segment) {
    for (int offset = -kRowsBeside; offset <= kRowsBeside; ++offset) {
      const auto other = rows.find({row_segment + segment, row_offset + offset});
      if (other == rows.end()) continue;
      const double weight =
          Weight(segment * kSegment_m, kAlongSigma_m) * Weight(offset * kRow_m, kOffsetSigma_m);
      around.Add(weight, other->second);
    }
  }
  return around;
}

std::vector<double> LateralRows::IntermittentShares(std::span<const RowVote> votes) const {
  std::map<Row, Tally> rows;
  for (std::size_t i = 0; i < votes.size(); ++i) rows[row_of_[i]].Add(1.0, votes[i]);
  std::map<Row, Tally> around;
  for (const auto& [row, tally] : rows) around.emplace(row, Around(row, rows));
  std::vector<double> shares;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    Tally of_others = around.at(row_of_[i]);
    of_others.Add(-1.0, votes[i]);
    shares.push_back(of_others.Share());
  }
  return shares;
}

}  // namespace dcloc
