#include "core/versions/update_gate.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "core/passes/pass_centers.h"
#include "core/versions/block_mean.h"
#include "core/versions/held_out_pass.h"
#include "core/versions/map_replay.h"
#include "core/versions/street_segments.h"
#include "core/versions/version_comparison.h"

namespace dcloc {
namespace {

constexpr std::size_t kFitStride = 3;  // scans from one whose fit is taken to the next

absl::StatusOr<std::shared_ptr<const RadarMap>> MapOf(const EditableMap& map) {
  auto bytes = ToMapBytes(map);
  if (!bytes.ok()) return bytes.status();
  return RadarMap::FromBytes(*std::move(bytes));
}

/// Landmarks of one kind in one segment, and how many of them the pass saw.
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

// Scans whose errors are taken for one: a sub-map's share theirs, some two seconds.
constexpr std::size_t kErrorBlock = 24;

struct SegmentSum {
  ScoreSum old_version, new_version;
  BlockMean error_change_m{kErrorBlock};
  SeenCount common, removed, added, intermittent;
  std::size_t scan_count = 0;
};

double ErrorOf(const ReplayedScan& scan, const Pose2& T_map_consensus) {
  return (scan.T_map_vehicle.translation_m - T_map_consensus.translation_m).norm();
}

SegmentEvaluation EvaluationOf(const SegmentSum& sum) {
  return {.scan_count = sum.scan_count,
          .agreed_count = sum.common.all,
          .removed_count = sum.removed.all,
          .added_count = sum.added.all,
          .intermittent_count = sum.intermittent.all,
          .agreed_seen = sum.common.Share(),
          .removed_seen = sum.removed.Share(),
          .added_seen = sum.added.Share(),
          .intermittent_seen = sum.intermittent.Share(),
          .error_change_m = sum.error_change_m.mean(),
          .error_change_sigma_m = sum.error_change_m.sigma(),
          .old_version = sum.old_version.Score(),
          .new_version = sum.new_version.Score()};
}

/// Of a segment in a street that the old version does not have. `agreed_seen` is of the others.
std::string FaultOfNew(const SegmentEvaluation& segment, double agreed_seen,
                       const UpdateGateOptions& options) {
  const VersionScore& after = segment.new_version;
  if (after.offset_m > options.max_new_offset_m) {
    return absl::StrFormat("the new street lies %.2f m from where odometry has it", after.offset_m);
  }
  if (after.error_m > options.max_new_error_m) {
    return absl::StrFormat("the error in the new street is %.2f m", after.error_m);
  }
  if (segment.added_seen < options.min_seen_share * agreed_seen) {
    return absl::StrFormat("%.0f %% of the new street was seen, elsewhere %.0f %%",
                           100.0 * segment.added_seen, 100.0 * agreed_seen);
  }
  return "";
}

/// Of so many landmarks the pass saw this share.
struct SeenShare {
  double share = 0.0;
  std::size_t count = 0;

  double Variance() const {
    return share * (1.0 - share) / std::max(1.0, static_cast<double>(count));
  }
};

/// By how many standard errors a share exceeds `factor` times that of what stays.
double SigmasAbove(const SeenShare& seen, double factor, const SeenShare& agreed) {
  const double variance = seen.Variance() + factor * factor * agreed.Variance();
  return (seen.share - factor * agreed.share) / std::sqrt(std::max(variance, 1e-9));
}

std::string Seen(const char* what, const SeenShare& seen, const SeenShare& agreed) {
  return absl::StrFormat("%.0f %% of what %s was seen, of what stays %.0f %%", 100.0 * seen.share,
                         what, 100.0 * agreed.share);
}

/// By how much the new version may do worse as a whole, or in one segment.
struct Margins {
  double error_share = 0.0;
  double error_m = 0.0;
  double tracking = 0.0;
};

std::string FaultOf(const SegmentEvaluation& segment, const Margins& margins,
                    const UpdateGateOptions& options) {
  const VersionScore& before = segment.old_version;
  const VersionScore& after = segment.new_version;
  const double old_count = static_cast<double>(segment.agreed_count + segment.removed_count);
  const auto min_count = static_cast<std::size_t>(options.min_landmark_count);
  if (static_cast<double>(segment.agreed_count) < options.min_agreed_share * old_count) {
    return absl::StrFormat("only %d of %.0f landmarks are left", segment.agreed_count, old_count);
  }
  if (after.tracking_share < before.tracking_share - margins.tracking) {
    return absl::StrFormat("tracks %.1f %% of the scans, before %.1f %%",
                           100.0 * after.tracking_share, 100.0 * before.tracking_share);
  }
  if (segment.error_change_m - options.error_sigmas * segment.error_change_sigma_m >
      margins.error_share * before.error_m + margins.error_m) {
    return absl::StrFormat("errors are larger by %.3f m, sigma %.3f m; before %.3f m",
                           segment.error_change_m, segment.error_change_sigma_m, before.error_m);
  }
  if (after.offset_m > options.max_offset_m) {
    return absl::StrFormat("its landmarks lie %.3f m from those of the old version",
                           after.offset_m);
  }
  if (after.fit < before.fit - options.fit_margin) {
    return absl::StrFormat("fit %.3f, before %.3f", after.fit, before.fit);
  }
  if (after.nees > options.nees_factor * before.nees + options.nees_margin) {
    return absl::StrFormat("NEES %.2f, before %.2f", after.nees, before.nees);
  }
  const SeenShare agreed{segment.agreed_seen, segment.agreed_count};
  const SeenShare added{segment.added_seen, segment.added_count};
  if (segment.added_count >= min_count &&
      SigmasAbove(added, options.min_seen_share, agreed) < -options.seen_sigmas) {
    return Seen("came", added, agreed);
  }
  const SeenShare removed{segment.removed_seen, segment.removed_count};
  if (segment.removed_count >= min_count &&
      SigmasAbove(removed, options.max_went_seen_share, agreed) > options.seen_sigmas) {
    return Seen("went", removed, agreed);
  }
  const SeenShare intermittent{segment.intermittent_seen, segment.intermittent_count};
  if (segment.intermittent_count >= min_count &&
      SigmasAbove(intermittent, options.max_went_seen_share, agreed) > options.seen_sigmas) {
    return Seen("comes and goes", intermittent, agreed);
  }
  return "";
}

/// One evaluation.
class UpdateEvaluator {
 public:
  UpdateEvaluator(const EditableMap& old_version, const EditableMap& new_version, const Rig& rig,
                  const std::vector<Scan>& scans,
                  const std::vector<Eigen::Vector2d>& intermittent_local_m,
                  const UpdateGateOptions& options)
      : rig_(rig),
        scans_(scans),
        options_(options),
        origin_m_(old_version.Origin_m()),
        old_version_{old_version, LandmarksOf(old_version)},
        new_version_{new_version, LandmarksOf(new_version)},
        intermittent_(intermittent_local_m),
        comparison_(CompareVersions(old_version, new_version, options.same_m, intermittent_)),
        segments_(new_version, options.segment_m),
        sums_(segments_.count()) {}

  absl::StatusOr<UpdateEvaluation> Run() {
    for (Version* const version : {&old_version_, &new_version_}) {
      auto map = MapOf(version->map);
      if (!map.ok()) return map.status();
      auto replay = ReplayPass(*map, rig_, scans_);
      if (!replay.ok()) return replay.status();
      version->replay = *std::move(replay);
    }
    held_out_ =
        PlaceInBoth(rig_, scans_, old_version_.replay, new_version_.replay, old_version_.landmarks,
                    new_version_.landmarks, KeyframesOf(old_version_.map), origin_m_);
    if (held_out_.scans.empty()) {
      return absl::FailedPreconditionError(
          "the pass that was kept out is not tracked in both versions: it lies elsewhere, or its "
          "rig is wrong");
    }
    Score();
    CountSeen();
    return Evaluation();
  }

 private:
  struct Version {
    const EditableMap& map;
    std::vector<PlacedLandmark> landmarks;
    std::vector<ReplayedScan> replay;
  };

  static std::vector<Eigen::Vector2d> KeyframesOf(const EditableMap& map) {
    std::vector<Eigen::Vector2d> positions_m;
    for (const EditableKeyframe& keyframe : map.keyframes) {
      positions_m.emplace_back(PoseOf(keyframe.record).translation_m.head<2>());
    }
    return positions_m;
  }

  Pose2 ToLocal(const Pose2& T_map_vehicle) const {
    return {T_map_vehicle.translation_m - origin_m_.head<2>(), T_map_vehicle.yaw_rad};
  }

  std::vector<RadarPoint> Judged(std::span<const RadarPoint> points,
                                 const Pose2& T_local_vehicle) const {
    std::vector<RadarPoint> judged;
    std::ranges::copy_if(points, std::back_inserter(judged), [&](const RadarPoint& point) {
      const Eigen::Vector2d p_vehicle = point.position_m.head<2>();
      return !intermittent_.HasNear(T_local_vehicle * p_vehicle, options_.intermittent_m);
    });
    return judged;
  }

  void Score() {
    const FitScorer old_fit(old_version_.landmarks);
    const FitScorer new_fit(new_version_.landmarks);
    for (std::size_t k = 0; k < held_out_.scans.size(); ++k) {
      const std::size_t i = held_out_.scans[k];
      const PlacedScan& scan = held_out_.pass.scans[k];
      const Pose2 T_map_consensus = Flatten(scan.T_map_vehicle);
      const Pose2 T_local_vehicle = ToLocal(T_map_consensus);
      std::vector<RadarPoint> points;
      if (k % kFitStride == 0) points = Judged(scan.points, T_local_vehicle);
      const double old_fit_sum = old_fit.Sum(points, T_local_vehicle);
      const double new_fit_sum = new_fit.Sum(points, T_local_vehicle);
      for (SegmentSum* const sum : {&sums_[segments_.At(T_local_vehicle.translation_m)], &whole_}) {
        ++sum->scan_count;
        sum->old_version.Add(old_version_.replay[i], T_map_consensus);
        sum->new_version.Add(new_version_.replay[i], T_map_consensus);
        // Beyond the old version it is odometry's, and says nothing of the whole.
        if (!scan.is_beyond_map || sum != &whole_) {
          sum->new_version.AddOffset(held_out_.T_old_new[k]);
        }
        if (!scan.is_beyond_map) {
          sum->error_change_m.Add(ErrorOf(new_version_.replay[i], T_map_consensus) -
                                  ErrorOf(old_version_.replay[i], T_map_consensus));
        }
        sum->old_version.AddFit(old_fit_sum, points.size());
        sum->new_version.AddFit(new_fit_sum, points.size());
      }
    }
    AddUntracked();
  }

  // Scans that only one version tracks, or none.
  void AddUntracked() {
    std::size_t next = 0;
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      if (next < held_out_.scans.size() && held_out_.scans[next] == i) {
        ++next;
        continue;
      }
      const bool is_old = old_version_.replay[i].is_tracking;
      const bool is_new = new_version_.replay[i].is_tracking;
      if (!is_old && !is_new) continue;  // before the first pose, in both
      const Pose2& T_map_vehicle = (is_old ? old_version_ : new_version_).replay[i].T_map_vehicle;
      for (SegmentSum* const sum :
           {&sums_[segments_.At(ToLocal(T_map_vehicle).translation_m)], &whole_}) {
        ++sum->scan_count;
        sum->old_version.AddTracking(is_old);
        sum->new_version.AddTracking(is_new);
      }
    }
  }

  void CountSeen() {
    const PlacedPass* const pass = &held_out_.pass;
    const std::vector<LandmarkPosition> centers = PositionsOf(FusePasses({&pass, 1}, origin_m_, 2));
    const auto count = [&](const std::vector<PlacedLandmark>& landmarks,
                           SeenCount SegmentSum::*member) {
      const std::vector<LandmarkPosition> positions = PositionsOf(landmarks);
      const std::vector<CenterMatch> center_of = MatchCenters(positions, centers);
      for (std::size_t i = 0; i < landmarks.size(); ++i) {
        const SeenCount one{1, center_of[i].center == kNoCenter ? 0UL : 1UL};
        (whole_.*member).Add(one);
        if (member == &SegmentSum::intermittent) continue;
        (sums_[segments_.At(positions[i].position_m)].*member).Add(one);
      }
    };
    count(comparison_.common, &SegmentSum::common);
    count(comparison_.removed, &SegmentSum::removed);
    count(comparison_.added, &SegmentSum::added);
    count(comparison_.intermittent, &SegmentSum::intermittent);
  }

  UpdateEvaluation Evaluation() const {
    UpdateEvaluation evaluation;
    evaluation.whole = EvaluationOf(whole_);
    evaluation.whole.fault = FaultOf(
        evaluation.whole, {options_.error_share, options_.error_margin_m, options_.tracking_margin},
        options_);
    std::string fault;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      SegmentEvaluation segment = EvaluationOf(sums_[i]);
      segment.p_map_m << segments_.Middle(i), 0.0;
      segment.p_map_m += origin_m_;
      if (segment.scan_count >= static_cast<std::size_t>(options_.min_scan_count)) {
        const bool is_new = segment.agreed_count + segment.removed_count == 0;
        segment.fault =
            is_new ? FaultOfNew(segment, evaluation.whole.agreed_seen, options_)
                   : FaultOf(segment,
                             {options_.segment_error_share, options_.segment_error_margin_m,
                              options_.segment_tracking_margin},
                             options_);
      }
      if (fault.empty() && !segment.fault.empty()) {
        fault = absl::StrFormat("at (%.0f, %.0f) m: %s", segment.p_map_m.x(), segment.p_map_m.y(),
                                segment.fault);
      }
      evaluation.segments.push_back(std::move(segment));
    }
    evaluation.reason = Reason(evaluation.whole, fault);
    evaluation.is_better = evaluation.reason.empty();
    if (evaluation.is_better) {
      evaluation.reason = "as good in every street segment, and it fits better";
    }
    return evaluation;
  }

  static std::string Reason(const SegmentEvaluation& whole, const std::string& segment_fault) {
    if (!whole.fault.empty()) return "worse as a whole: " + whole.fault;
    if (!segment_fault.empty()) return "worse in a street segment, " + segment_fault;
    const std::size_t gone_count = whole.removed_count + whole.intermittent_count;
    if (whole.added_count + gone_count == 0) return "nothing has changed";
    if (whole.added_count > 0 && whole.new_version.fit <= whole.old_version.fit) {
      return absl::StrFormat("no better: fit %.4f, before %.4f", whole.new_version.fit,
                             whole.old_version.fit);
    }
    return "";
  }

  const Rig& rig_;
  const std::vector<Scan>& scans_;
  const UpdateGateOptions& options_;
  Eigen::Vector3d origin_m_;
  Version old_version_, new_version_;
  PlaceSet intermittent_;
  VersionComparison comparison_;
  StreetSegments segments_;
  HeldOutPass held_out_;
  std::vector<SegmentSum> sums_;
  SegmentSum whole_;
};

}  // namespace

absl::StatusOr<UpdateEvaluation> EvaluateUpdate(
    const EditableMap& old_version, const EditableMap& new_version, const Rig& rig,
    const std::vector<Scan>& scans, const std::vector<Eigen::Vector2d>& intermittent_local_m,
    const UpdateGateOptions& options) {
  if (old_version.keyframes.empty() || scans.empty()) {
    return absl::InvalidArgumentError("the old version has no keyframe, or the pass no scan");
  }
  return UpdateEvaluator(old_version, new_version, rig, scans, intermittent_local_m, options).Run();
}

}  // namespace dcloc
