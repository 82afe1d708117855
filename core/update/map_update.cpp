#include "core/update/map_update.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "core/map/keyframe_index.h"
#include "core/map/landmark_points.h"
#include "core/passes/landmark_refinement.h"
#include "core/passes/pass_centers.h"
#include "core/update/base_landmarks.h"
#include "core/update/detection_model.h"
#include "core/update/exposure.h"
#include "core/update/false_hits.h"
#include "core/update/lateral_rows.h"
#include "core/update/presence_fit.h"

namespace dcloc {
namespace {

double Days(Stamp from, Stamp to) {
  return std::chrono::duration<double, std::ratio<86400>>(to - from).count();
}

/// One update: what passes say of all places, known ones first.
class Updater {
 public:
  Updater(const EditableMap& base_map, std::span<const PlacedPass> passes,
          const MapUpdateOptions& options)
      : base_map_(base_map), options_(options), base_(base_map) {
    for (std::size_t i = 0; i < passes.size(); ++i) {
      if (passes[i].GoodCount() > 0) result_.order.push_back(i);
    }
    std::ranges::stable_sort(result_.order, {},
                             [&](std::size_t i) { return FirstGoodStamp(passes[i]); });
    for (const std::size_t i : result_.order) aligned_.push_back(passes[i]);
    for (const PlacedPass& pass : aligned_) passes_.push_back(&pass);
    witness_of_ = FirstOfWitness(aligned_);
  }

  absl::StatusOr<MapUpdate> Run() && {
    if (passes_.empty()) {
      return absl::InvalidArgumentError("no pass has a scan that was tracked in the map");
    }
    AlignPasses(base_.landmarks, base_map_.Origin_m(), options_.alignment, aligned_);
    JoinNewStreets();
    FindOthers();
    LookAtPlaces();
    result_.presence = options_.presence;
    result_.presence.false_share = false_hits_.share;
    result_.presence.false_hits = false_hits_.mean;
    EstimatePresence();
    ChangeMap();
    return std::move(result_);
  }

 private:
  std::size_t KnownCount() const { return base_.positions.size(); }

  void JoinNewStreets() {
    T_local_keyframes_ = base_.T_local_keyframes;
    result_.new_streets = FindNewStreets(base_.T_local_keyframes, aligned_, base_map_.Origin_m(),
                                         options_.min_witnesses, options_.new_streets);
    const std::vector<Pose3>& joined = result_.new_streets.T_local_keyframes;
    T_local_keyframes_.insert(T_local_keyframes_.end(), joined.begin(), joined.end());
  }

  // The keyframe that a landmark belongs to; none where all are too far.
  std::optional<std::size_t> KeyframeOf(const Landmark& landmark) const {
    std::optional<std::size_t> nearest;
    double nearest_m = kMaxKeyframeDistance_m;
    for (std::size_t k = 0; k < T_local_keyframes_.size(); ++k) {
      const double distance_m =
          (T_local_keyframes_[k].translation_m - landmark.position_m).head<2>().norm();
      if (distance_m >= nearest_m) continue;
      nearest_m = distance_m;
      nearest = k;
    }
    return nearest;
  }

  bool IsInNewStreet(const Landmark& landmark) const {
    const std::optional<std::size_t> keyframe = KeyframeOf(landmark);
    return keyframe && *keyframe >= base_.T_local_keyframes.size();
  }

  // What the passes together see: where the base map has nothing, in its streets and then in new
  // ones, and after it where it has. Scans beyond the map are placed well enough among themselves,
  // but not beside what the map has: they speak of new streets alone.
  void FindOthers() {
    positions_ = base_.positions;
    const std::vector<Landmark> tracked = Fused(ScanChoice::kTracked);
    found_in_base_count_ = Take(tracked, Kind::kInBase);
    const bool has_new = !result_.new_streets.T_local_keyframes.empty();
    found_count_ =
        has_new ? Take(Fused(ScanChoice::kAll), Kind::kInNewStreet) : found_in_base_count_;
    Take(tracked, Kind::kKnown);
  }

  std::vector<Landmark> Fused(ScanChoice choice) const {
    return FusePasses(passes_, base_map_.Origin_m(), 3, choice);
  }

  enum class Kind { kInBase, kInNewStreet, kKnown };

  // Those of one kind become the next places; how many others there are then.
  std::size_t Take(const std::vector<Landmark>& seen, Kind wanted) {
    const std::vector<LandmarkPosition> positions = PositionsOf(seen);
    const std::vector<CenterMatch> known =
        MatchCenters(positions, base_.positions, options_.matching);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Kind kind = known[i].center != kNoCenter ? Kind::kKnown
                        : IsInNewStreet(seen[i])     ? Kind::kInNewStreet
                                                     : Kind::kInBase;
      if (kind != wanted) continue;
      others_.push_back(seen[i]);
      known_of_other_.push_back(known[i].center);
      positions_.push_back(positions[i]);
    }
    return others_.size();
  }

  /// What one pass sees of places.
  struct Look {
    std::vector<Landmark> seen;
    std::vector<CenterMatch> matches;
    std::vector<Exposure> exposures;
  };
  Look LookOf(const PlacedPass* pass, std::span<const LandmarkPosition> places,
              ScanChoice choice) const {
    Look look{.seen =
                  FusePasses({&pass, 1}, base_map_.Origin_m(), options_.min_center_scans, choice)};
    look.matches = MatchCenters(places, PositionsOf(look.seen), options_.matching);
    std::vector<Eigen::Vector2d> places_m;
    for (const LandmarkPosition& place : places) places_m.push_back(place.position_m);
    look.exposures = Expose(*pass, base_map_.Origin_m(), places_m, choice);
    return look;
  }

  void LookAtPlaces() {
    const std::span<const LandmarkPosition> all(positions_);
    const std::size_t new_begin = KnownCount() + found_in_base_count_;
    const auto new_places = all.subspan(new_begin, found_count_ - found_in_base_count_);
    for (const PlacedPass* const pass : passes_) {
      const Look in_base = LookOf(pass, all, ScanChoice::kTracked);
      const Look in_new = new_places.empty() ? Look{} : LookOf(pass, new_places, ScanChoice::kAll);
      PassSightings sightings;
      std::vector<double>& ratios = position_ratios_.emplace_back();
      for (std::size_t i = 0; i < all.size(); ++i) {
        const bool is_new = i >= new_begin && i - new_begin < new_places.size();
        const Look& look = is_new ? in_new : in_base;
        const std::size_t k = is_new ? i - new_begin : i;
        const CenterMatch& match = look.matches[k];
        sightings.exposures.push_back(look.exposures[k]);
        ratios.push_back(match.position_ratio);
        sightings.hits.push_back(
            match.center == kNoCenter ? 0 : static_cast<int>(look.seen[match.center].scan_count));
      }
      false_hits_.Add(all.first(KnownCount() + found_count_), in_base.seen, options_.matching);
      sightings_.push_back(std::move(sightings));
    }
    false_hits_.Finish();
  }

  std::vector<PassEvidence> EvidenceOf(const DetectionModel& detection, std::size_t i) const {
    std::vector<PassEvidence> evidence;
    for (std::size_t p = 0; p < passes_.size(); ++p) {
      const double days = p == 0
                              ? options_.base_age_days
                              : Days(FirstGoodStamp(*passes_[p - 1]), FirstGoodStamp(*passes_[p]));
      const double expected = i < KnownCount()
                                  ? detection.ExpectedHits(p, i)
                                  : detection.ExpectedHits(p, sightings_[p].exposures[i]);
      evidence.push_back({expected, sightings_[p].hits[i], position_ratios_[p][i], days});
    }
    return evidence;
  }

  void EstimatePresence() {
    std::vector<PassSightings> known = sightings_;
    for (PassSightings& pass : known) {
      pass.exposures.resize(KnownCount());
      pass.hits.resize(KnownCount());
    }
    const std::vector<Exposure> base =
        ExposeFrom(base_.T_local_keyframes, passes_.front()->rig, Positions(KnownCount()));
    const LateralRows rows(base_.T_local_keyframes, Positions(positions_.size()));
    std::vector<double> presence(KnownCount(), 1.0);
    for (int round = 0; round < 4; ++round) {
      const DetectionModel detection(known, base, base_.scans, presence);
      std::vector<std::vector<PassEvidence>> evidence;
      for (std::size_t i = 0; i < positions_.size(); ++i) {
        evidence.push_back(EvidenceOf(detection, i));
      }
      result_.presence = FitPresence(
          std::span(evidence).first(KnownCount()),
          std::span(evidence).subspan(KnownCount(), found_in_base_count_), result_.presence);
      Describe(std::move(evidence));
      intermittent_shares_ = rows.IntermittentShares(RowVotes());
      for (std::size_t i = 0; i < KnownCount(); ++i) presence[i] = result_.known[i].presence.stays;
    }
  }

  std::vector<Eigen::Vector2d> Positions(std::size_t count) const {
    std::vector<Eigen::Vector2d> positions;
    for (std::size_t i = 0; i < count; ++i) positions.push_back(positions_[i].position_m);
    return positions;
  }

  // What is real comes and goes as often as what lies in its row.
  PresenceModel ModelOf(std::size_t i) const {
    return intermittent_shares_.empty()
               ? result_.presence
               : WithIntermittent(result_.presence, intermittent_shares_[i]);
  }

  bool IsWhereThingsComeAndGo(std::size_t i) const {
    return !intermittent_shares_.empty() && intermittent_shares_[i] > 0.5;
  }

  // What is known and seen again votes once. New streets do not: there all that was seen is new.
  std::vector<RowVote> RowVotes() const {
    std::vector<RowVote> votes;
    const auto vote = [&](const LandmarkHistory& history) {
      const Presence& presence = history.presence;
      const std::vector<std::size_t>& missed_by = history.absence_witnesses;
      RowVote& of = votes.emplace_back();
      if (!missed_by.empty()) of.intermittent = presence.intermittent;
      if (missed_by.size() == 1) of.only_witness = missed_by.front();
      const bool is_witnessed = history.witness_count >= options_.min_witnesses;
      if (is_witnessed) of.lasts = presence.stays + presence.added;
    };
    std::ranges::for_each(result_.known, vote);
    std::ranges::for_each(std::span(result_.found).first(found_in_base_count_), vote);
    votes.resize(positions_.size());
    return votes;
  }

  void Describe(std::vector<std::vector<PassEvidence>> evidence) {
    result_.known.clear();
    result_.found.clear();
    again_.clear();
    // What is seen again is as any known landmark: most of it stays. So is what a new street shows.
    // Where the known landmark does not stay, it is a candidate as any other.
    PresenceModel again = result_.presence;
    again.found_intermittent = again.known_intermittent;
    again.found_never = again.known_removed;
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      LandmarkHistory history;
      history.p_map_m << positions_[i].position_m, 0.0;
      history.p_map_m += base_map_.Origin_m();
      history.passes = std::move(evidence[i]);
      CountWitnesses(history);
      if (i < KnownCount()) {
        history.presence = PosteriorOfMapLandmark(history.passes, ModelOf(i));
        history.fate = FateOfKnown(history, IsWhereThingsComeAndGo(i));
        result_.known.push_back(std::move(history));
      } else {
        const bool is_found = i < KnownCount() + found_count_;
        const bool is_in_base = i < KnownCount() + found_in_base_count_;
        const bool is_candidate = is_found ? is_in_base : !IsKept(i);
        history.presence = PosteriorOfCandidate(history.passes, is_candidate ? ModelOf(i) : again);
        history.fate = FateOfFound(history);
        (is_found ? result_.found : again_).push_back(std::move(history));
      }
    }
  }

  // Of something that is seen again, whether the known landmark is.
  bool IsKept(std::size_t i) const {
    return result_.known[known_of_other_[i - KnownCount()]].fate == LandmarkFate::kKept;
  }

  void CountWitnesses(LandmarkHistory& history) const {
    std::set<std::size_t> witnesses, absence_witnesses;
    std::set<std::string> vehicles;
    for (std::size_t p = 0; p < passes_.size(); ++p) {
      const PassEvidence& pass = history.passes[p];
      if (pass.hits == 0) {
        if (pass.expected_hits > 1.0) absence_witnesses.insert(witness_of_[p]);
        continue;
      }
      witnesses.insert(witness_of_[p]);
      vehicles.insert(passes_[p]->vehicle);
      const Stamp at = FirstGoodStamp(*passes_[p]);
      if (!history.first_seen) history.first_seen = at;
      history.last_seen = at;
    }
    history.witness_count = static_cast<int>(witnesses.size());
    history.vehicle_count = static_cast<int>(vehicles.size());
    history.absence_witnesses.assign(absence_witnesses.begin(), absence_witnesses.end());
  }

  // Where things come and go by enough witnesses, a landmark does not need as many of its own.
  LandmarkFate FateOfKnown(const LandmarkHistory& history, bool is_where_things_come_and_go) const {
    const Presence& presence = history.presence;
    const bool is_witnessed = is_where_things_come_and_go ||
                              std::ssize(history.absence_witnesses) >= options_.min_witnesses;
    if (presence.stays >= options_.min_keep_probability || !is_witnessed) {
      return LandmarkFate::kKept;
    }
    return presence.removed >= presence.intermittent ? LandmarkFate::kRemoved
                                                     : LandmarkFate::kIntermittent;
  }

  LandmarkFate FateOfFound(const LandmarkHistory& history) const {
    const Presence& presence = history.presence;
    if (presence.added >= options_.min_add_probability &&
        history.witness_count >= options_.min_witnesses) {
      return LandmarkFate::kAdded;
    }
    return presence.intermittent > presence.never && presence.intermittent > presence.added
               ? LandmarkFate::kIntermittent
               : LandmarkFate::kUnproven;
  }

  void ChangeMap() {
    const std::vector<Landmark> refined = Refined();
    const std::vector<CenterMatch> refined_of =
        MatchCenters(base_.positions, PositionsOf(refined), options_.matching);
    result_.map = base_map_;
    // What vehicles can expect of it is not known.
    for (EditableKeyframe& keyframe : result_.map.keyframes) keyframe.record.accuracy = 0;
    result_.refined_count = refined.size();
    std::size_t i = 0;
    for (EditableKeyframe& keyframe : result_.map.keyframes) {
      std::erase_if(keyframe.points, [&](const MapPoint&) {
        const std::size_t known = i++;
        return result_.known[known].fate != LandmarkFate::kKept ||
               refined_of[known].center != kNoCenter;
      });
    }
    for (const Pose3& T_local_keyframe : result_.new_streets.T_local_keyframes) {
      result_.map.keyframes.push_back({.record = RecordOf(T_local_keyframe), .points = {}});
    }
    result_.map.info.length_m += result_.new_streets.joined_m;
    for (const Landmark& landmark : refined) AddLandmark(landmark);
    for (std::size_t k = 0; k < others_.size(); ++k) {
      const bool is_found = k < found_count_;
      if (!is_found && IsKept(KnownCount() + k)) continue;
      const LandmarkHistory& history = is_found ? result_.found[k] : again_[k - found_count_];
      if (history.fate == LandmarkFate::kAdded) AddLandmark(others_[k]);
    }
  }

  // What stays and enough witnesses saw again, as the base map and they have it together.
  std::vector<Landmark> Refined() const {
    std::vector<Landmark> refined;
    for (std::size_t k = 0; k < again_.size(); ++k) {
      const std::size_t other = found_count_ + k;
      const std::uint32_t known = known_of_other_[other];
      if (again_[k].fate != LandmarkFate::kAdded || !IsKept(KnownCount() + other)) continue;
      refined.push_back(Blend(base_.landmarks[known], others_[other]));
    }
    return refined;
  }

  void AddLandmark(const Landmark& landmark) {
    const std::optional<std::size_t> keyframe = KeyframeOf(landmark);
    if (!keyframe) return;
    EditableKeyframe& nearest = result_.map.keyframes[*keyframe];
    const bool has_heights = (base_map_.info.flags & kHasHeightsFlag) != 0;
    nearest.points.push_back(PointInKeyframe(landmark, PoseOf(nearest.record), has_heights));
  }

  const EditableMap& base_map_;
  const MapUpdateOptions& options_;
  BaseLandmarks base_;
  std::vector<Pose3> T_local_keyframes_;   // the base map's, then those of new streets
  std::vector<PlacedPass> aligned_;        // by stamp
  std::vector<const PlacedPass*> passes_;  // the same
  std::vector<std::size_t> witness_of_;    // of each pass, the first of the same witness
  std::vector<Landmark> others_;           // what passes see: found, then seen again
  std::size_t found_in_base_count_ = 0;
  std::size_t found_count_ = 0;                // these, and those in new streets
  std::vector<std::uint32_t> known_of_other_;  // the base map's landmark at the place
  std::vector<LandmarkPosition> positions_;    // of the base map's landmarks, then of others
  std::vector<LandmarkHistory> again_;         // of what is seen again
  std::vector<PassSightings> sightings_;
  std::vector<std::vector<double>> position_ratios_;  // by pass and place
  std::vector<double> intermittent_shares_;           // of the rows of places; none at first
  FalseHits false_hits_;
  MapUpdate result_;
};

}  // namespace

absl::StatusOr<MapUpdate> UpdateMap(const EditableMap& base, std::span<const PlacedPass> passes,
                                    const MapUpdateOptions& options) {
  return Updater(base, passes, options).Run();
}

}  // namespace dcloc
