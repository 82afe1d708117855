#include "core/update/update_gate.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <set>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "core/odometry/ego_motion.h"
#include "core/update/map_replay.h"
#include "core/update/pass_centers.h"
#include "core/update/placed_pass.h"

namespace dcloc {
namespace {

constexpr std::size_t kFitStride = 3;  // scans from one whose fit is taken to the next

absl::StatusOr<std::shared_ptr<const RadarMap>> MapOf(const MapParts& parts) {
  auto bytes = PutTogether(parts);
  if (!bytes.ok()) return bytes.status();
  return RadarMap::FromBytes(*std::move(bytes));
}

bool IsSamePlace(const MapPoint& a, const MapPoint& b) {
  return std::memcmp(&a, &b, offsetof(MapPoint, rcs_dbsm)) == 0;
}

bool IsSamePose(const KeyframeRecord& a, const KeyframeRecord& b) {
  return a.translation_local_m == b.translation_local_m && a.rotation_wxyz == b.rotation_wxyz;
}

/// What two versions have alike, and each alone; `agreed` is a map too.
struct Difference {
  MapParts agreed;
  std::vector<PlacedLandmark> common, went, came;
};

std::vector<MapPoint> Without(const std::vector<MapPoint>& points,
                              const std::vector<MapPoint>& others) {
  std::vector<MapPoint> left;
  std::ranges::copy_if(points, std::back_inserter(left), [&](const MapPoint& point) {
    return std::ranges::none_of(others,
                                [&](const MapPoint& other) { return IsSamePlace(point, other); });
  });
  return left;
}

Difference Compare(const MapParts& old_version, const MapParts& new_version) {
  Difference difference{.agreed = old_version};
  MapParts went = old_version;
  MapParts came = new_version;
  for (std::size_t k = 0; k < old_version.keyframes.size(); ++k) {
    const bool is_in_both =
        k < new_version.keyframes.size() &&
        IsSamePose(old_version.keyframes[k].record, new_version.keyframes[k].record);
    if (!is_in_both) {
      difference.agreed.keyframes[k].points.clear();
      continue;
    }
    const std::vector<MapPoint>& old_points = old_version.keyframes[k].points;
    const std::vector<MapPoint>& new_points = new_version.keyframes[k].points;
    went.keyframes[k].points = Without(old_points, new_points);
    came.keyframes[k].points = Without(new_points, old_points);
    difference.agreed.keyframes[k].points = Without(old_points, went.keyframes[k].points);
  }
  difference.common = LandmarksOf(difference.agreed);
  difference.went = LandmarksOf(went);
  difference.came = LandmarksOf(came);
  return difference;
}

/// Stretches of the way, by the keyframes of the old version.
class Streets {
 public:
  Streets(const MapParts& map, double street_m) {
    double at_m = 0.0;
    for (const KeyframePart& keyframe : map.keyframes) {
      const Eigen::Vector2d p_m = PoseOf(keyframe.record).translation_m.head<2>();
      if (!p_local_m_.empty()) at_m += std::min((p_m - p_local_m_.back()).norm(), street_m);
      p_local_m_.push_back(p_m);
      street_of_.push_back(static_cast<std::size_t>(at_m / street_m));
    }
  }

  std::size_t count() const { return street_of_.back() + 1; }
  std::size_t OfKeyframe(std::size_t k) const {
    return street_of_[std::min(k, street_of_.size() - 1)];
  }
  std::size_t At(const Eigen::Vector2d& p_m) const {
    const auto nearest = std::ranges::min_element(
        p_local_m_, {},
        [&](const Eigen::Vector2d& keyframe_m) { return (keyframe_m - p_m).norm(); });
    return street_of_[static_cast<std::size_t>(nearest - p_local_m_.begin())];
  }
  Eigen::Vector2d Middle(std::size_t street) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double count = 0.0;
    for (std::size_t k = 0; k < street_of_.size(); ++k) {
      if (street_of_[k] != street) continue;
      sum += p_local_m_[k];
      count += 1.0;
    }
    return sum / count;
  }

 private:
  std::vector<Eigen::Vector2d> p_local_m_;  // of keyframes
  std::vector<std::size_t> street_of_;
};

/// Landmarks of one kind in one street, and how many of them the pass saw.
struct SeenCount {
  std::size_t all = 0;
  std::size_t seen = 0;

  double Share() const {
    return all == 0 ? 0.0 : static_cast<double>(seen) / static_cast<double>(all);
  }
  void Add(const SeenCount& other) {
    all += other.all;
    seen += other.seen;
  }
};

struct StreetSum {
  ScoreSum old_version, new_version;
  SeenCount common, went, came;
  std::size_t scan_count = 0;
};

StreetVerdict VerdictOf(const StreetSum& sum) {
  return {.scan_count = sum.scan_count,
          .agreed_count = sum.common.all,
          .went_count = sum.went.all,
          .came_count = sum.came.all,
          .agreed_seen = sum.common.Share(),
          .went_seen = sum.went.Share(),
          .came_seen = sum.came.Share(),
          .old_version = sum.old_version.Score(),
          .new_version = sum.new_version.Score()};
}

std::string FaultOf(const StreetVerdict& street, const UpdateGateOptions& options) {
  const VersionScore& before = street.old_version;
  const VersionScore& after = street.new_version;
  const double old_count = static_cast<double>(street.agreed_count + street.went_count);
  const auto min_count = static_cast<std::size_t>(options.min_landmark_count);
  if (static_cast<double>(street.agreed_count) < options.min_agreed_share * old_count) {
    return absl::StrFormat("only %d of %.0f landmarks are left as they were", street.agreed_count,
                           old_count);
  }
  if (after.tracking_share < before.tracking_share - options.tracking_margin) {
    return absl::StrFormat("tracks %.1f %% of the scans, before %.1f %%",
                           100.0 * after.tracking_share, 100.0 * before.tracking_share);
  }
  if (after.scatter_m > options.scatter_factor * before.scatter_m + options.scatter_margin_m) {
    return absl::StrFormat("median scatter %.3f m, before %.3f m", after.scatter_m,
                           before.scatter_m);
  }
  if (after.scatter_p90_m >
      options.scatter_factor * before.scatter_p90_m + 2.0 * options.scatter_margin_m) {
    return absl::StrFormat("90 %% of the scatter below %.3f m, before %.3f m", after.scatter_p90_m,
                           before.scatter_p90_m);
  }
  if (after.offset_m > options.max_offset_m) {
    return absl::StrFormat("its track lies %.3f m from that of what both versions have",
                           after.offset_m);
  }
  if (after.fit < before.fit - options.fit_margin) {
    return absl::StrFormat("fit %.3f, before %.3f", after.fit, before.fit);
  }
  if (after.nees > options.nees_factor * before.nees + options.nees_margin) {
    return absl::StrFormat("NEES %.2f, before %.2f", after.nees, before.nees);
  }
  if (street.came_count >= min_count &&
      street.came_seen < options.min_seen_share * street.agreed_seen) {
    return absl::StrFormat("%.0f %% of what came was seen, of what stays %.0f %%",
                           100.0 * street.came_seen, 100.0 * street.agreed_seen);
  }
  if (street.went_count >= min_count &&
      street.went_seen > options.min_seen_share * street.agreed_seen) {
    return absl::StrFormat("%.0f %% of what went was seen, of what stays %.0f %%",
                           100.0 * street.went_seen, 100.0 * street.agreed_seen);
  }
  return "";
}

/// One judgement: the pass in both versions and in what they agree on.
class Judge {
 public:
  Judge(const MapParts& old_version, const MapParts& new_version, const Rig& rig,
        const std::vector<Scan>& scans, const UpdateGateOptions& options)
      : old_version_(old_version),
        new_version_(new_version),
        rig_(rig),
        scans_(scans),
        options_(options),
        difference_(Compare(old_version, new_version)),
        streets_(old_version, options.street_m),
        sums_(streets_.count()) {}

  absl::StatusOr<GateVerdict> Run() {
    auto old_replay = Replay(old_version_);
    if (!old_replay.ok()) return old_replay.status();
    auto new_replay = Replay(new_version_);
    if (!new_replay.ok()) return new_replay.status();
    auto agreed = Replay(difference_.agreed);
    if (!agreed.ok()) {
      return absl::FailedPreconditionError("the versions have no landmark in common");
    }
    consensus_ = ConsensusOf(*agreed, rig_, scans_);
    if (std::ranges::none_of(consensus_, [](const auto& pose) { return pose.has_value(); })) {
      return absl::FailedPreconditionError(
          "the pass that was kept out is not tracked in what the versions have in common");
    }
    Score(
        {*old_replay, ConsensusOf(*old_replay, rig_, scans_), FitScorer(LandmarksOf(old_version_))},
        {*new_replay, ConsensusOf(*new_replay, rig_, scans_),
         FitScorer(LandmarksOf(new_version_))});
    CountSeen();
    return Verdict();
  }

 private:
  absl::StatusOr<std::vector<ReplayedScan>> Replay(const MapParts& parts) const {
    auto map = MapOf(parts);
    if (!map.ok()) return map.status();
    return ReplayPass(*map, rig_, scans_);
  }

  Pose2 ToLocal(const Pose2& T_map_vehicle) const {
    return {T_map_vehicle.translation_m - old_version_.Origin_m().head<2>(), T_map_vehicle.yaw_rad};
  }

  /// The pass in one version: its answers, its track, and how scans fit its landmarks.
  struct VersionReplay {
    const std::vector<ReplayedScan>& answers;
    std::vector<std::optional<Pose2>> track;
    FitScorer fit;
  };

  void Score(const VersionReplay& old_version, const VersionReplay& new_version) {
    EgoMotion ego_motion;
    Stamp newest{};
    pass_.rig = rig_;
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      const RadarModel* const radar = rig_.Find(scans_[i].radar_id);
      if (radar == nullptr || scans_[i].stamp < newest) continue;
      newest = scans_[i].stamp;
      const EgoVelocity& velocity = ego_motion.Advance(scans_[i], *radar);
      if (!consensus_[i]) continue;
      PlacedScan placed{.stamp = newest,
                        .radar = rig_.IndexOf(scans_[i].radar_id),
                        .T_map_vehicle = Embed(*consensus_[i]),
                        .is_good = true,
                        .points = StaticPoints(scans_[i], *radar, velocity, {})};
      for (StreetSum* const sum :
           {&sums_[streets_.At(ToLocal(*consensus_[i]).translation_m)], &whole_}) {
        ++sum->scan_count;
        AddTo(sum->old_version, old_version, i, placed.points);
        AddTo(sum->new_version, new_version, i, placed.points);
      }
      pass_.scans.push_back(std::move(placed));
    }
  }

  void AddTo(ScoreSum& sum, const VersionReplay& version, std::size_t i,
             const std::vector<RadarPoint>& points) const {
    sum.Add(version.answers[i], version.track[i], *consensus_[i]);
    if (i % kFitStride != 0 || !version.track[i]) return;
    sum.AddFit(version.fit.Sum(points, ToLocal(*version.track[i])), points.size());
  }

  void CountSeen() {
    const PlacedPass* const pass = &pass_;
    const std::vector<PlaceEstimate> centers =
        PlacesOf(FusePasses({&pass, 1}, old_version_.Origin_m(), 2));
    std::vector<PlaceEstimate> places;
    for (const auto* landmarks : {&difference_.common, &difference_.went, &difference_.came}) {
      for (const PlacedLandmark& landmark : *landmarks) places.push_back(landmark.place);
    }
    const std::vector<CenterMatch> center_of = MatchCenters(places, centers);
    std::size_t next = 0;
    const auto count = [&](const std::vector<PlacedLandmark>& landmarks,
                           SeenCount StreetSum::*member) {
      for (const PlacedLandmark& landmark : landmarks) {
        const SeenCount one{1, center_of[next++].center == kNoCenter ? 0UL : 1UL};
        (sums_[streets_.OfKeyframe(landmark.keyframe)].*member).Add(one);
        (whole_.*member).Add(one);
      }
    };
    count(difference_.common, &StreetSum::common);
    count(difference_.went, &StreetSum::went);
    count(difference_.came, &StreetSum::came);
  }

  GateVerdict Verdict() const {
    GateVerdict verdict;
    verdict.whole = VerdictOf(whole_);
    verdict.whole.fault = FaultOf(verdict.whole, options_);
    std::string street_fault;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      StreetVerdict street = VerdictOf(sums_[i]);
      street.p_map_m << streets_.Middle(i), 0.0;
      street.p_map_m += old_version_.Origin_m();
      if (street.scan_count >= static_cast<std::size_t>(options_.min_scan_count)) {
        street.fault = FaultOf(street, options_);
      }
      if (street_fault.empty() && !street.fault.empty()) {
        street_fault = absl::StrFormat("at (%.0f, %.0f) m: %s", street.p_map_m.x(),
                                       street.p_map_m.y(), street.fault);
      }
      verdict.streets.push_back(std::move(street));
    }
    verdict.reason = Reason(verdict.whole, street_fault);
    verdict.is_better = verdict.reason.empty();
    if (verdict.is_better) verdict.reason = "as good in every street, and it fits better";
    return verdict;
  }

  static std::string Reason(const StreetVerdict& whole, const std::string& street_fault) {
    if (!whole.fault.empty()) return "worse as a whole: " + whole.fault;
    if (!street_fault.empty()) return "worse in a street, " + street_fault;
    if (whole.came_count + whole.went_count == 0) return "nothing has changed";
    if (whole.came_count > 0 && whole.new_version.fit <= whole.old_version.fit) {
      return absl::StrFormat("no better: fit %.4f, before %.4f", whole.new_version.fit,
                             whole.old_version.fit);
    }
    return "";
  }

  const MapParts& old_version_;
  const MapParts& new_version_;
  const Rig& rig_;
  const std::vector<Scan>& scans_;
  const UpdateGateOptions& options_;
  Difference difference_;
  Streets streets_;
  std::vector<std::optional<Pose2>> consensus_;
  PlacedPass pass_;  // at the consensus
  std::vector<StreetSum> sums_;
  StreetSum whole_;
};

}  // namespace

absl::StatusOr<GateVerdict> JudgeUpdate(const MapParts& old_version, const MapParts& new_version,
                                        const Rig& rig, const std::vector<Scan>& scans,
                                        const UpdateGateOptions& options) {
  if (old_version.keyframes.empty() || scans.empty()) {
    return absl::InvalidArgumentError("the old version has no keyframe, or the pass no scan");
  }
  return Judge(old_version, new_version, rig, scans, options).Run();
}

}  // namespace dcloc
