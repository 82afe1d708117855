#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/map/editable_map.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/versions/version_score.h"

namespace dcloc {

/// When a new version is better than the old one, or as good.
struct UpdateGateOptions {
  double segment_m = 100.0;  ///< length of a street segment
  double same_m = 0.5;       ///< landmarks of both versions that are nearer are one
  // The error of the new version may surely be larger by a share of the old one's and a margin.
  double error_share = 0.05;
  double error_margin_m = 0.002;
  double segment_error_share = 0.3;  ///< likewise in one segment
  double segment_error_margin_m = 0.015;
  double segment_tracking_margin = 0.05;  ///< half a second of dead reckoning in 100 m
  double error_sigmas = 2.0;              ///< standard errors of the difference that make it sure
  double max_offset_m = 0.06;     ///< by which the new version's landmarks may lie to one side
  double tracking_margin = 0.02;  ///< share of scans that the new version may track less
  double fit_margin = 0.01;       ///< that the new version may fit less
  double nees_factor = 1.3;       ///< of the old version's NEES, and `nees_margin` more
  double nees_margin = 0.7;
  double min_agreed_share = 0.4;  ///< of a segment's landmarks, that both versions have
  double min_seen_share = 0.5;    ///< of new landmarks seen, against that of agreed ones
  /// Likewise, at most, of landmarks that went or come and go: what was taken by mistake is seen as
  /// any other.
  double max_went_seen_share = 0.75;
  double seen_sigmas = 2.0;     ///< standard errors that make such a difference sure
  double intermittent_m = 0.8;  ///< what lies so near to a place that comes and goes is not judged
  // In a segment that only the new version has: how far odometry may have it elsewhere, and the
  // error.
  double max_new_offset_m = 2.0;
  double max_new_error_m = 0.3;
  int min_scan_count = 10;      ///< of a segment; shorter ones are not judged by themselves
  int min_landmark_count = 12;  ///< likewise
};

/// How both versions do in a street segment, or as a whole.
struct SegmentEvaluation {
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();  ///< its middle
  std::size_t scan_count = 0;
  std::size_t agreed_count = 0;  ///< landmarks that both versions have
  std::size_t removed_count = 0;
  std::size_t added_count = 0;
  std::size_t intermittent_count = 0;  ///< removed, too, as they come and go; of the whole only
  double agreed_seen = 0.0;            ///< share of the agreed landmarks that the pass saw
  double removed_seen = 0.0;
  double added_seen = 0.0;
  double intermittent_seen = 0.0;
  /// By how much the new version errs more than the old one, in the mean of the scans that both
  /// track, and its standard error.
  double error_change_m = 0.0;
  double error_change_sigma_m = 0.0;
  VersionScore old_version;
  VersionScore new_version;
  std::string fault;  ///< why the new version is worse here; empty where it is not
};

struct UpdateEvaluation {
  bool is_better = false;
  std::string reason;  ///< a sentence
  SegmentEvaluation whole;
  std::vector<SegmentEvaluation> segments;
};

/// Evaluates a new version by a pass that had no part in it.
///
/// The pass is aligned with the landmarks of the old version, and with those of the new one
/// (`AlignPass`): by its odometry and by what it sees as a whole, and not by the answers that are
/// judged. The consensus is the middle of the two, so that neither version is right by definition;
/// how far they lie apart is the offset. Against the consensus count the error and the NEES of what
/// a vehicle is told in each version, besides the share of scans that track, and how static targets
/// fit. The new version must be as good as a whole and in each street segment, and fit better or be
/// more accurate. In streets that only the new version has it must lie where odometry has them, and
/// show what the pass saw; those that the pass did not drive are not judged.
///
/// Where things come and go, at `intermittent_local_m`, no version is judged by what it has: the
/// old one may have vehicles that parked, and others park there now. But they must be seen less
/// often than what stays.
///
/// The versions share a frame and an origin. InvalidArgument names what is wrong with the rig;
/// FailedPrecondition where the pass was not localized in both.
absl::StatusOr<UpdateEvaluation> EvaluateUpdate(
    const EditableMap& old_version, const EditableMap& new_version, const Rig& rig,
    const std::vector<Scan>& scans, const std::vector<Eigen::Vector2d>& intermittent_local_m,
    const UpdateGateOptions& options = {});

}  // namespace dcloc
