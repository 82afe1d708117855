#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/map/map_parts.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/update/version_score.h"

namespace dcloc {

/// When a new version is better than the old one, or as good.
struct UpdateGateOptions {
  double street_m = 100.0;          ///< length of a stretch that is judged by itself
  double scatter_factor = 1.15;     ///< of the old version's scatter, that the new one may have
  double scatter_margin_m = 0.015;  ///< and so much more
  double max_offset_m = 0.1;        ///< of the new version's track from that of what both have
  double tracking_margin = 0.02;    ///< share of scans that the new version may track less
  double fit_margin = 0.01;         ///< that the new version may fit less
  double nees_factor = 1.3;         ///< of the old version's NEES, and `nees_margin` more
  double nees_margin = 0.7;
  double min_agreed_share = 0.4;  ///< of a street's landmarks, that both versions have
  double min_seen_share = 0.5;    ///< of new landmarks seen, against that of agreed ones
  int min_scan_count = 10;        ///< of a street; shorter ones are not judged by themselves
  int min_landmark_count = 12;    ///< likewise
};

/// A stretch of the way, by the keyframes of the old version.
struct StreetVerdict {
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();  ///< its middle
  std::size_t scan_count = 0;
  std::size_t agreed_count = 0;  ///< landmarks that both versions have
  std::size_t went_count = 0;
  std::size_t came_count = 0;
  double agreed_seen = 0.0;  ///< share of the agreed landmarks that the pass saw
  double went_seen = 0.0;
  double came_seen = 0.0;
  VersionScore old_version;
  VersionScore new_version;
  std::string fault;  ///< why the new version is worse here; empty where it is not
};

struct GateVerdict {
  bool is_better = false;
  std::string reason;  ///< a sentence
  StreetVerdict whole;
  std::vector<StreetVerdict> streets;
};

/// Judges a new version by a pass that had no part in it. Each version is scored about the track
/// that it and odometry make; how far that lies from the track of the landmarks that both versions
/// have is bounded besides. The new version must be
/// as good in every street, and better by what it fits or by what it need not carry any more. The
/// maps share a frame. InvalidArgument names what is wrong with the rig; FailedPrecondition where
/// the pass was not localized, or the versions have too little in common.
absl::StatusOr<GateVerdict> JudgeUpdate(const MapParts& old_version, const MapParts& new_version,
                                        const Rig& rig, const std::vector<Scan>& scans,
                                        const UpdateGateOptions& options = {});

}  // namespace dcloc
