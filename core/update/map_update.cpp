#include "core/update/map_update.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "core/map/landmark_points.h"
#include "core/passes/landmark_refinement.h"
#include "core/passes/pass_centers.h"
#include "core/update/base_landmarks.h"
#include "core/update/detection_model.h"
#include "core/update/exposure.h"
#include "core/update/lateral_rows.h"
#include "core/update/presence_fit.h"
#include "core/update/seen_places.h"
#include "core/update/updated_keyframes.h"

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
    if (passes_.empty() || base_map_.keyframes.empty()) {
      return absl::InvalidArgumentError("no pass has a scan that was tracked in the map");
    }
    AlignPasses(base_.landmarks, base_map_.Origin_m(), options_.alignment, aligned_);
    result_.new_streets = FindNewStreets(base_.T_local_keyframes, aligned_, base_map_.Origin_m(),
                                         options_.min_witnesses, options_.new_streets);
    const UpdatedKeyframes keyframes(base_.T_local_keyframes,
                                     result_.new_streets.T_local_keyframes);
    places_ = FindSeenPlaces(base_, keyframes, passes_, base_map_.Origin_m(), options_.places);
    EstimatePresence();
    ChangeMap(keyframes);
    return std::move(result_);
  }

 private:
  std::vector<PassEvidence> EvidenceOf(const DetectionModel& detection, std::size_t i) const {
    std::vector<PassEvidence> evidence;
    for (std::size_t p = 0; p < passes_.size(); ++p) {
      const double days = p == 0
                              ? options_.base_age_days
                              : Days(FirstGoodStamp(*passes_[p - 1]), FirstGoodStamp(*passes_[p]));
      const double expected = i < places_.known_count
                                  ? detection.ExpectedHits(p, i)
                                  : detection.ExpectedHits(p, places_.sightings[p].exposures[i]);
      evidence.push_back(
          {expected, places_.sightings[p].hits[i], places_.position_ratios[p][i], days});
    }
    return evidence;
  }

  void EstimatePresence() {
    result_.presence = options_.presence;
    result_.presence.false_share = places_.false_hits.share;
    result_.presence.false_hits = places_.false_hits.mean;
    std::vector<PassSightings> known = places_.sightings;
    for (PassSightings& pass : known) {
      pass.exposures.resize(places_.known_count);
      pass.hits.resize(places_.known_count);
    }
    const std::vector<Exposure> base = ExposeFrom(base_.T_local_keyframes, passes_.front()->rig,
                                                  places_.FirstPlaces_m(places_.known_count));
    const LateralRows rows(base_.T_local_keyframes,
                           places_.FirstPlaces_m(places_.positions.size()));
    std::vector<double> presence(places_.known_count, 1.0);
    for (int round = 0; round < 4; ++round) {
      const DetectionModel detection(known, base, base_.scans, presence);
      std::vector<std::vector<PassEvidence>> evidence;
      for (std::size_t i = 0; i < places_.positions.size(); ++i) {
        evidence.push_back(EvidenceOf(detection, i));
      }
      result_.presence =
          FitPresence(std::span(evidence).first(places_.known_count),
                      std::span(evidence).subspan(places_.known_count, places_.found_in_base_count),
                      result_.presence);
      Describe(std::move(evidence));
      intermittent_shares_ = rows.IntermittentShares(RowVotes());
      for (std::size_t i = 0; i < places_.known_count; ++i) {
        presence[i] = result_.known[i].presence.stays;
      }
    }
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
    std::ranges::for_each(std::span(result_.found).first(places_.found_in_base_count), vote);
    votes.resize(places_.positions.size());
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
    for (std::size_t i = 0; i < places_.positions.size(); ++i) {
      LandmarkHistory history;
      history.p_map_m << places_.positions[i].position_m, 0.0;
      history.p_map_m += base_map_.Origin_m();
      history.passes = std::move(evidence[i]);
      CountWitnesses(history);
      if (i < places_.known_count) {
        history.presence = PosteriorOfMapLandmark(history.passes, ModelOf(i));
        history.fate = FateOfKnown(history, IsWhereThingsComeAndGo(i));
        result_.known.push_back(std::move(history));
      } else {
        const bool is_found = i < places_.known_count + places_.found_count;
        const bool is_in_base = i < places_.known_count + places_.found_in_base_count;
        const bool is_candidate = is_found ? is_in_base : !IsKept(i);
        history.presence = PosteriorOfCandidate(history.passes, is_candidate ? ModelOf(i) : again);
        history.fate = FateOfFound(history);
        (is_found ? result_.found : again_).push_back(std::move(history));
      }
    }
  }

  // Of something that is seen again, whether the known landmark is.
  bool IsKept(std::size_t i) const {
    return result_.known[places_.known_of_other[i - places_.known_count]].fate ==
           LandmarkFate::kKept;
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

  void ChangeMap(const UpdatedKeyframes& keyframes) {
    const std::vector<Landmark> refined = Refined();
    const std::vector<CenterMatch> refined_of =
        MatchCenters(base_.positions, PositionsOf(refined), options_.places.matching);
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
    for (const Landmark& landmark : refined) AddLandmark(landmark, keyframes);
    for (std::size_t k = 0; k < places_.others.size(); ++k) {
      const bool is_found = k < places_.found_count;
      if (!is_found && IsKept(places_.known_count + k)) continue;
      const LandmarkHistory& history =
          is_found ? result_.found[k] : again_[k - places_.found_count];
      if (history.fate == LandmarkFate::kAdded) AddLandmark(places_.others[k], keyframes);
    }
  }

  // What stays and enough witnesses saw again, as the base map and they have it together.
  std::vector<Landmark> Refined() const {
    std::vector<Landmark> refined;
    for (std::size_t k = 0; k < again_.size(); ++k) {
      const std::size_t other = places_.found_count + k;
      const std::uint32_t known = places_.known_of_other[other];
      if (again_[k].fate != LandmarkFate::kAdded || !IsKept(places_.known_count + other)) continue;
      refined.push_back(Blend(base_.landmarks[known], places_.others[other]));
    }
    return refined;
  }

  void AddLandmark(const Landmark& landmark, const UpdatedKeyframes& keyframes) {
    const std::optional<std::size_t> keyframe = keyframes.Of(landmark);
    if (!keyframe) return;
    EditableKeyframe& nearest = result_.map.keyframes[*keyframe];
    const bool has_heights = (base_map_.info.flags & kHasHeightsFlag) != 0;
    nearest.points.push_back(PointInKeyframe(landmark, PoseOf(nearest.record), has_heights));
  }

  const EditableMap& base_map_;
  const MapUpdateOptions& options_;
  BaseLandmarks base_;
  std::vector<PlacedPass> aligned_;        // by stamp
  std::vector<const PlacedPass*> passes_;  // the same
  std::vector<std::size_t> witness_of_;    // of each pass, the first of the same witness
  SeenPlaces places_;
  std::vector<double> intermittent_shares_;  // of the rows of places; none at first
  std::vector<LandmarkHistory> again_;       // of what is seen again
  MapUpdate result_;
};

}  // namespace

absl::StatusOr<MapUpdate> UpdateMap(const EditableMap& base, std::span<const PlacedPass> passes,
                                    const MapUpdateOptions& options) {
  return Updater(base, passes, options).Run();
}

}  // namespace dcloc
