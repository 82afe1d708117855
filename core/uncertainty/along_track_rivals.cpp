#include "core/uncertainty/along_track_rivals.h"

#include <algorithm>
#include <cmath>

namespace dcloc {

std::span<const OptionField<AlongTrackRivalOptions>> FieldsOf(
    const AlongTrackRivalOptions& /*options*/) {
  using O = AlongTrackRivalOptions;
  static constexpr OptionField<O> kFields[] = {
      {"step_m", &O::step_m, 0.1, 100},
      {"min_offset_m", &O::min_offset_m, 0.1, 100},
      {"max_offset_m", &O::max_offset_m, 0, 100, "there are no rivals"},
      {"pose_sigma_m", &O::pose_sigma_m, 0, 100, "poses are compared as exact"},
      {"point_sigma", &O::point_sigma, 1e-6, 1},
      {"places_per_scan", &O::places_per_scan, 2, 10'000},
      {"max_point_count", &O::max_point_count, 1, 1'000'000},
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
  chosen_offsets_m_.reserve(1 + hypotheses_.size());
}

std::span<const double> AlongTrackRivals::NextOffsets_m() {
  chosen_.clear();
  chosen_offsets_m_.clear();
  if (hypotheses_.empty()) return {};
  chosen_offsets_m_.push_back(0.0);
  const std::size_t count = CountToChoose();
  for (std::size_t i = 0; i < hypotheses_.size() && chosen_.size() < count / 2; ++i) {
    const std::size_t index = (turn_ + i) % hypotheses_.size();
    if (hypotheses_[index].better.sum() > 0.0) Choose(index);
  }
  while (chosen_.size() < count) {
    if (std::ranges::find(chosen_, turn_) == chosen_.end()) Choose(turn_);
    turn_ = (turn_ + 1) % hypotheses_.size();
    if (turn_ == 0 && round_count_ < options_.beginning_rounds) ++round_count_;
  }
  return chosen_offsets_m_;
}

std::size_t AlongTrackRivals::CountToChoose() const {
  const bool begins = round_count_ < options_.beginning_rounds;
  const int count = options_.places_per_scan * (begins ? options_.beginning_factor : 1);
  return std::min(static_cast<std::size_t>(count), hypotheses_.size());
}

void AlongTrackRivals::Choose(std::size_t index) {
  chosen_.push_back(index);
  chosen_offsets_m_.push_back(hypotheses_[index].offset_m);
}

// METHOD eq 60.
void AlongTrackRivals::OnFits(std::size_t point_count, std::span<const double> fits) {
  const double sigma = options_.point_sigma / std::sqrt(static_cast<double>(point_count));
  for (std::size_t i = 0; i < chosen_.size(); ++i) {
    hypotheses_[chosen_[i]].better.Add((fits[i + 1] - fits[0]) / sigma, options_.better);
  }
}

void AlongTrackRivals::LearnRepetition(std::span<const double> fits) {
  if (fits.size() < 2 || fits[0] <= 0.0) return;
  best_fraction_.Add(std::ranges::max(fits.subspan(1)) / fits[0], options_.forgetting_factor);
}

bool AlongTrackRivals::has_better() const {
  return std::ranges::any_of(hypotheses_, [](const OffsetHypothesis& hypothesis) {
    return hypothesis.better.is_exceeded();
  });
}

void AlongTrackRivals::Reset() {
  for (OffsetHypothesis& hypothesis : hypotheses_) hypothesis.better = {};
  round_count_ = 0;
}

}  // namespace dcloc
