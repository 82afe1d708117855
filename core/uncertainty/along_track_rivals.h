#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/forgetting_mean.h"
#include "core/geometry/pose.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/uncertainty/one_sided_cusum.h"

namespace dcloc {

/// Which places along the road are held against the pose, and when one of them fits better.
struct AlongTrackRivalOptions {
  // Rivals lie ahead and behind. Nearer places are distinguished by registration.
  double step_m = 0.25;        ///< distance between neighbouring rivals
  double min_offset_m = 1.5;   ///< distance of the nearest rival from the pose
  double max_offset_m = 24.0;  ///< distance of the furthest one, at most; 0: no rivals
  /// One rival is registered in so many registrations of the pose, and after each of them while one
  /// that was not beaten is the last; 0: none is.
  int registrations_per_rival = 5;
  double max_shift_m = 1.5;  ///< by which a registration moves the same place
  /// A registered rival leads by so much for each unit of its score above that of the pose: the
  /// log-likelihood ratio of a global localization (METHOD eq 38).
  double lead_per_score = 36.0;
  OneSidedCusumOptions leads = {.drift = 0.5, .max = 3.5, .limit = 4.5};
  /// A rival is beaten by a pose whose score is higher by this. A pose that begins stands out once
  /// it has beaten so many in a row, those that scans fit best of all.
  double beating_score = 0.04;
  int min_beaten_count = 3;
  int max_wait_count = 10;  ///< registrations without a scan that could be compared: it stands out
  /// Poses are compared as if they were as uncertain as this: steps shall miss no place.
  double pose_sigma_m = 0.3;
  /// Standard deviation of what one point adds to the difference of two fits.
  double point_sigma = 0.35;
  /// When a rival fits better for sure.
  OneSidedCusumOptions better = {.drift = 1.0, .max = 3.5, .limit = 8.0};
  /// Where the ground does not repeat, and nothing speaks for a rival, one of so many scans of a
  /// radar is compared.
  int scan_interval = 3;
  int places_per_scan = 12;              ///< places that one scan is compared at
  int max_point_count = 50;              ///< of a scan's points, for as many are laid at each place
  int max_registered_point_count = 600;  ///< of a sub-map's points, for as many are registered
  /// A pose that begins is compared at this many times as many places, until each has had its turn
  /// `beginning_rounds` times.
  int beginning_factor = 3;
  int beginning_rounds = 3;
  /// The ground repeats where the best rival of a scan fits by this fraction of what the pose does,
  /// on average. In towns it fits by 0.3, on highways by 0.6.
  double repeating_fraction = 0.45;
  double forgetting_factor = 0.9;  ///< weight of an older scan beside the next, [0, 1)
};
std::span<const OptionField<AlongTrackRivalOptions>> FieldsOf(
    const AlongTrackRivalOptions& options);
absl::Status Validate(const AlongTrackRivalOptions& options);

/// Holds the pose against places before and behind it. Where posts repeat, registration fits a
/// scan to the wrong ones as it does to the right ones. But what stands between them does not
/// repeat: laid into the map at both places, scans show which of the two is right (METHOD eq 60).
/// Some rivals are registered like the pose, with a sub-map's many points, and that shows it
/// sooner.
class AlongTrackRivals {
 public:
  explicit AlongTrackRivals(const AlongTrackRivalOptions& options);

  /// As uncertain are poses to be taken that are compared [m].
  double pose_sigma_m() const { return options_.pose_sigma_m; }

  /// Of a scan, as many points are to be compared at most.
  int max_point_count() const { return options_.max_point_count; }

  /// Of a sub-map, as many points are to be registered at most.
  int max_registered_point_count() const { return options_.max_registered_point_count; }

  /// A scan of radar `index`, which is `in_doubt` unless all is as usual. Returns whether it is to
  /// be compared.
  bool IsDue(std::size_t index, bool in_doubt);

  /// Chooses where the next scan is to be compared: T_vehicle_place, the pose itself first; none if
  /// there are no rivals. The road bends to the left by `curvature_radpm` radians a metre. Up to
  /// half of the rivals have fitted better so far; the others take turns, so that each is compared
  /// now and then. Valid until the next call.
  std::span<const Pose2> NextPlaces(double curvature_radpm);

  /// `point_count` points of a scan fit the map by `fits` at the places chosen last: [0, 1].
  void OnFits(std::size_t point_count, std::span<const double> fits);

  /// The pose has been registered. Returns how many rivals are to be registered, too: a
  /// registration puts the pose where scans fit best, and a place of a coarse row is no match for
  /// that. As long as the pose does not stand out they are several, after each round. Once a rival
  /// was not beaten, each registration is followed by one, until some were beaten in a row.
  int CountToRegister();

  /// T_vehicle_place of the next one: the rival that leads, or that scans have fitted better, or
  /// else that the newest scans fitted best. In between, rivals take turns. None where nothing is
  /// known of others, or where only a rival that leads or fits better would be of interest.
  std::optional<Pose2> NextToRegister();

  /// That has put the rival at `T_vehicle_place`, with a score that exceeds the pose's by
  /// `score_lead`. What went far is another place, and nothing is learned of it.
  void OnRegistered(const Pose2& T_vehicle_place, double score_lead);

  /// Takes in the fits at the places chosen last, of a scan that lies in the map where the pose is.
  void LearnRepetition(std::span<const double> fits);

  /// Whether scans that fit here would fit places nearby, too.
  bool ground_repeats() const { return best_fraction_.mean >= options_.repeating_fraction; }

  /// Whether the pose was registered with a higher score than its rivals, since it was found. At a
  /// wrong place, or in the map of another street, none is much better than others. While the pose
  /// begins, no rival may lead.
  bool stands_out() const;

  /// It did so a moment ago.
  void SupposeThatItStandsOut() { stands_out_ = true; }

  /// Whether scans or registrations fit another place better for sure.
  bool has_better() const;

  /// The vehicle is where it was supposed to be.
  void Reset();

  /// The vehicle is supposed to be somewhere else.
  void OnPlaceFound();

 private:
  static constexpr double kNone = -std::numeric_limits<double>::infinity();

  struct OffsetHypothesis {
    double offset_m = 0.0;
    OneSidedCusum better;        // by single scans
    OneSidedCusum leads;         // by registrations
    double newest_lead = kNone;  // of the newest scan's fit, unless a registration told more since
    bool had_turn = false;       // was registered, or one beside it, since all others were
  };

  bool Begins() const { return round_count_ < options_.beginning_rounds; }
  bool AreRegistered() const {
    return !hypotheses_.empty() && options_.registrations_per_rival > 0;
  }
  bool MayBeElsewhere() const;
  std::size_t CountToChoose() const;
  void Choose(std::size_t index);
  std::size_t Challenger() const;
  std::size_t NextInTurn();
  void BeginRound();
  // A registration would put both at the same place.
  bool AreBeside(const OffsetHypothesis& one, const OffsetHypothesis& other) const {
    return std::abs(one.offset_m - other.offset_m) <= options_.max_shift_m;
  }
  bool HasFittedBetter(const OffsetHypothesis& hypothesis) const {
    return hypothesis.leads.sum() > 0.0 || hypothesis.better.sum() > 0.0;
  }
  Pose2 PlaceAt(double offset_m) const;

  AlongTrackRivalOptions options_;
  std::vector<OffsetHypothesis> hypotheses_;
  std::array<int, kMaxRadars> scan_counts_{};  // of each radar, since one was compared
  double curvature_radpm_ = 0.0;               // of the road's line
  std::size_t turn_ = 0;                       // the hypothesis whose turn is next
  int round_count_ = 0;              // turns that each has had since the beginning; or kAllAtOnce
  int registration_count_ = 0;       // of the pose, since a rival was registered
  std::vector<std::size_t> chosen_;  // of the hypotheses, for the next scan
  std::vector<Pose2> places_;        // the pose and those chosen
  std::size_t challenger_ = 0;       // the hypothesis that is registered
  int wait_count_ = 0;               // registrations of a pose that begins, none compared
  std::size_t compared_count_ = 0;   // rivals, since one was not beaten
  int beaten_count_ = 0;             // rivals in a row
  bool stands_out_ = false;
  ForgettingMean best_fraction_;  // of the best rival's fit in that of the pose
  double newest_fraction_ = 0.0;  // the newest of these
};

}  // namespace dcloc
