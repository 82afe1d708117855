#include "core/uncertainty/along_track_rivals.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace dcloc {
namespace {

constexpr int kAllAtOnce = -1;  // the first round, of a place that was found

}  // namespace

std::span<const OptionField<AlongTrackRivalOptions>> FieldsOf(
    const AlongTrackRivalOptions& /*options*/) {
  using O = AlongTrackRivalOptions;
  static constexpr OptionField<O> kFields[] = {
      {"step_m", &O::step_m, 0.1, 100},
      {"min_offset_m", &O::min_offset_m, 0.1, 100},
      {"max_offset_m", &O::max_offset_m, 0, 100, "there are no rivals"},
      {"registrations_per_rival", &O::registrations_per_rival, 0, 1'000'000,
       "no rival is registered"},
      {"max_shift_m", &O::max_shift_m, 1e-6, 100},
      {"lead_per_score", &O::lead_per_score, 0, 1'000, "registered rivals never lead"},
      {"beating_score", &O::beating_score, 0, 1, "any lead of the pose is enough"},
      {"min_beaten_count", &O::min_beaten_count, 1, 1'000},
      {"max_wait_count", &O::max_wait_count, 0, 1'000'000, "a pose need not stand out"},
      {"pose_sigma_m", &O::pose_sigma_m, 0, 100, "poses are compared as exact"},
      {"point_sigma", &O::point_sigma, 1e-6, 1},
      {"scan_interval", &O::scan_interval, 1, 1'000},
      {"places_per_scan", &O::places_per_scan, 2, 10'000},
      {"max_point_count", &O::max_point_count, 1, 1'000'000},
      {"max_registered_point_count", &O::max_registered_point_count, 1, 1'000'000},
      {"beginning_factor", &O::beginning_factor, 1, 1'000},
      {"repeating_fraction", &O::repeating_fraction, 0, 10, "all ground repeats"},
      {"forgetting_factor", &O::forgetting_factor, 0, 0.999'999, "the newest scan alone counts"},
      {"beginning_rounds", &O::beginning_rounds, 0, 10'000, "a pose begins as it goes on"},
  };
  return kFields;
}

absl::Status Validate(const AlongTrackRivalOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("better", Validate(options.better)));
  status.Update(Within("leads", Validate(options.leads)));
  return status;
}

AlongTrackRivals::AlongTrackRivals(const AlongTrackRivalOptions& options) : options_(options) {
  double offset_m = options.min_offset_m;
  while (offset_m <= options.max_offset_m) {
    hypotheses_.push_back({.offset_m = offset_m});
    hypotheses_.push_back({.offset_m = -offset_m});
    offset_m += options.step_m;
  }
  chosen_.reserve(hypotheses_.size());
  places_.reserve(1 + hypotheses_.size());
}

bool AlongTrackRivals::IsDue(std::size_t index, bool in_doubt) {
  int& count = scan_counts_.at(index);
  ++count;
  if (count < options_.scan_interval && !in_doubt && !MayBeElsewhere()) return false;
  count = 0;
  return true;
}

bool AlongTrackRivals::MayBeElsewhere() const {
  const auto has_fitted_better = [this](const OffsetHypothesis& rival) {
    return HasFittedBetter(rival);
  };
  return Begins() || !stands_out() || best_fraction_.count == 0 || ground_repeats() ||
         newest_fraction_ >= options_.repeating_fraction ||
         std::ranges::any_of(hypotheses_, has_fitted_better);
}

std::span<const Pose2> AlongTrackRivals::NextPlaces(double curvature_radpm) {
  curvature_radpm_ = curvature_radpm;
  chosen_.clear();
  places_.clear();
  if (hypotheses_.empty()) return {};
  places_.push_back({});
  const std::size_t count = CountToChoose();
  for (std::size_t i = 0; i < hypotheses_.size() && chosen_.size() < count / 2; ++i) {
    const std::size_t index = (turn_ + i) % hypotheses_.size();
    if (HasFittedBetter(hypotheses_[index])) Choose(index);
  }
  while (chosen_.size() < count) {
    if (std::ranges::find(chosen_, turn_) == chosen_.end()) Choose(turn_);
    turn_ = (turn_ + 1) % hypotheses_.size();
    if (turn_ == 0 && Begins()) ++round_count_;
  }
  return places_;
}

std::size_t AlongTrackRivals::CountToChoose() const {
  if (round_count_ == kAllAtOnce) return hypotheses_.size();
  const int count = options_.places_per_scan * (Begins() ? options_.beginning_factor : 1);
  return std::min(static_cast<std::size_t>(count), hypotheses_.size());
}

void AlongTrackRivals::Choose(std::size_t index) {
  chosen_.push_back(index);
  places_.push_back(PlaceAt(hypotheses_[index].offset_m));
}

// Half of an arc's turn is the direction of its chord.
Pose2 AlongTrackRivals::PlaceAt(double offset_m) const {
  const double half_turn_rad = 0.5 * curvature_radpm_ * offset_m;
  const double chord_m =
      half_turn_rad == 0.0 ? offset_m : offset_m * std::sin(half_turn_rad) / half_turn_rad;
  return {
      .translation_m = chord_m * Eigen::Vector2d(std::cos(half_turn_rad), std::sin(half_turn_rad)),
      .yaw_rad = 2.0 * half_turn_rad};
}

// METHOD eq 60.
void AlongTrackRivals::OnFits(std::size_t point_count, std::span<const double> fits) {
  const double sigma = options_.point_sigma / std::sqrt(static_cast<double>(point_count));
  wait_count_ = 0;
  compared_count_ += chosen_.size();
  for (std::size_t i = 0; i < chosen_.size(); ++i) {
    OffsetHypothesis& hypothesis = hypotheses_[chosen_[i]];
    hypothesis.newest_lead = (fits[i + 1] - fits[0]) / sigma;
    hypothesis.better.Add(hypothesis.newest_lead, options_.better);
  }
}

int AlongTrackRivals::CountToRegister() {
  if (!AreRegistered()) return 0;
  if (!stands_out_) {
    if (++wait_count_ > options_.max_wait_count) stands_out_ = true;
    const bool all_are_compared = compared_count_ >= hypotheses_.size();
    return all_are_compared ? options_.min_beaten_count - beaten_count_ : 0;
  }
  const bool is_due = ++registration_count_ >= options_.registrations_per_rival;
  return is_due || beaten_count_ < options_.min_beaten_count ? 1 : 0;
}

std::optional<Pose2> AlongTrackRivals::NextToRegister() {
  if (!stands_out_ && compared_count_ == 0) return std::nullopt;
  const bool takes_turn = stands_out_ && registration_count_ < options_.registrations_per_rival;
  challenger_ = takes_turn ? NextInTurn() : Challenger();
  const OffsetHypothesis& challenger = hypotheses_[challenger_];
  if (challenger.newest_lead == kNone) {
    compared_count_ = 0;
    return std::nullopt;
  }
  const bool may_repeat = ground_repeats() || best_fraction_.count == 0;
  const bool is_of_interest = HasFittedBetter(challenger) || may_repeat || !stands_out_;
  if (!is_of_interest) return std::nullopt;
  if (!takes_turn) registration_count_ = 0;
  return PlaceAt(challenger.offset_m);
}

std::size_t AlongTrackRivals::Challenger() const {
  const auto rank = [](const OffsetHypothesis& hypothesis) {
    return std::tuple(hypothesis.newest_lead > kNone, hypothesis.leads.sum(),
                      hypothesis.better.sum(), hypothesis.newest_lead);
  };
  return static_cast<std::size_t>(std::ranges::max_element(hypotheses_, {}, rank) -
                                  hypotheses_.begin());
}

// What leads is registered anyway. Sooner, its sub-map would be the same.
void AlongTrackRivals::BeginRound() {
  for (OffsetHypothesis& hypothesis : hypotheses_) {
    hypothesis.had_turn = std::ranges::any_of(hypotheses_, [&](const OffsetHypothesis& other) {
      return other.leads.sum() > 0.0 && AreBeside(other, hypothesis);
    });
  }
}

// Of those that scans were compared at since, the one that they fit best.
std::size_t AlongTrackRivals::NextInTurn() {
  const auto rank = [](const OffsetHypothesis& hypothesis) {
    if (hypothesis.had_turn) return kNone;
    return hypothesis.newest_lead;
  };
  auto next = std::ranges::max_element(hypotheses_, {}, rank);
  if (rank(*next) == kNone) {
    BeginRound();
    next = std::ranges::max_element(hypotheses_, {}, rank);
  }
  return static_cast<std::size_t>(next - hypotheses_.begin());
}

void AlongTrackRivals::OnRegistered(const Pose2& T_vehicle_place, double score_lead) {
  OffsetHypothesis& challenger = hypotheses_[challenger_];
  for (OffsetHypothesis& other : hypotheses_) {
    if (!AreBeside(other, challenger)) continue;
    other.newest_lead = kNone;
    other.had_turn = true;
  }
  const Pose2 place = PlaceAt(challenger.offset_m);
  const double shift_m = (T_vehicle_place.translation_m - place.translation_m).norm();
  const bool stayed = shift_m <= options_.max_shift_m;
  challenger.leads.Add(options_.lead_per_score * (stayed ? score_lead : 0.0), options_.leads);

  const bool is_pose = T_vehicle_place.translation_m.norm() < 0.5 * options_.min_offset_m;
  if (is_pose || (stayed && score_lead <= -options_.beating_score)) {
    ++beaten_count_;
  } else if (stayed) {
    beaten_count_ = 0;
    compared_count_ = 0;
  }
  if (beaten_count_ >= options_.min_beaten_count) stands_out_ = true;
}

void AlongTrackRivals::LearnRepetition(std::span<const double> fits) {
  if (fits.size() < 2 || fits[0] <= 0.0) return;
  newest_fraction_ = std::ranges::max(fits.subspan(1)) / fits[0];
  best_fraction_.Add(newest_fraction_, options_.forgetting_factor);
}

bool AlongTrackRivals::stands_out() const {
  if (!AreRegistered()) return true;
  const auto leads = [](const OffsetHypothesis& rival) { return rival.leads.sum() > 0.0; };
  return stands_out_ && !(Begins() && std::ranges::any_of(hypotheses_, leads));
}

bool AlongTrackRivals::has_better() const {
  return std::ranges::any_of(hypotheses_, [](const OffsetHypothesis& hypothesis) {
    return hypothesis.better.is_exceeded() || hypothesis.leads.is_exceeded();
  });
}

void AlongTrackRivals::Reset() {
  for (OffsetHypothesis& hypothesis : hypotheses_) {
    hypothesis.better = {};
    hypothesis.leads = {};
  }
  round_count_ = 0;
}

void AlongTrackRivals::OnPlaceFound() {
  Reset();
  for (OffsetHypothesis& hypothesis : hypotheses_) hypothesis.newest_lead = kNone;
  round_count_ = kAllAtOnce;  // it waits for a round to be claimed
  wait_count_ = 0;
  compared_count_ = 0;
  beaten_count_ = 0;
  stands_out_ = false;
}

}  // namespace dcloc
