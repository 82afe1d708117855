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
      {"scan_count", &O::scan_count, 0, 1'000'000, "a confirmed pose has no rivals"},
  };
  return kFields;
}

absl::Status Validate(const AlongTrackRivalOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("better", Validate(options.better)));
  return status;
}

AlongTrackRivals::AlongTrackRivals(const AlongTrackRivalOptions& options) : options_(options) {
  for (double offset_m = options.min_offset_m; offset_m <= options.max_offset_m;
       offset_m += options.step_m) {
    offsets_m_.push_back(offset_m);
    offsets_m_.push_back(-offset_m);
  }
  better_.resize(offsets_m_.size());
}

// METHOD eq 60.
void AlongTrackRivals::OnFits(std::size_t point_count, bool is_confirmed, double fit,
                              std::span<const double> rival_fits) {
  confirmed_count_ = is_confirmed ? confirmed_count_ + 1 : 0;
  const double sigma = options_.point_sigma / std::sqrt(static_cast<double>(point_count));
  for (std::size_t i = 0; i < better_.size(); ++i) {
    better_[i].Add((rival_fits[i] - fit) / sigma, options_.better);
  }
}

bool AlongTrackRivals::has_better() const {
  return std::ranges::any_of(better_, &CumulativeSum::is_exceeded);
}

void AlongTrackRivals::Reset() {
  std::ranges::fill(better_, CumulativeSum{});
  confirmed_count_ = 0;
}

}  // namespace dcloc
