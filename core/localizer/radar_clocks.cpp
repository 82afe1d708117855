#include "core/localizer/radar_clocks.h"

#include <algorithm>

namespace dcloc {

std::span<const OptionField<RadarClocksOptions>> FieldsOf(const RadarClocksOptions& /*options*/) {
  using O = RadarClocksOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_behind_ms", &O::max_behind, 0, 1e5, "every late scan counts"},
      {"max_ahead_ms", &O::max_ahead, 0, 1e5, "every scan ahead counts"},
      {"max_lead_ms", &O::max_lead, 1, 1e6},
      {"min_scans", &O::min_scans, 2, 100},
      {"offset_sigma_s", &O::offset_sigma_s, 1e-6, 10},
      {"min_suspected_ms", &O::min_suspected, 0, 1e4, "any order that is not the stamps' counts"},
      {"fit_forgetting_factor", &O::fit_forgetting_factor, 0, 0.999,
       "the newest scan alone counts"},
      {"deciding_fit", &O::deciding_fit, 1e-3, 100},
      {"rest_scans", &O::rest_scans, 0, 1'000'000, "a clock is suspected again at once"},
  };
  return kFields;
}

absl::Status Validate(const RadarClocksOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::optional<ScalarEstimate> RadarClocks::OffsetEstimate(std::size_t index) const {
  if (!IsOff(index)) return std::nullopt;
  return ScalarEstimate{SecondsOf(Offset(index)),
                        options_.offset_sigma_s * options_.offset_sigma_s};
}

std::optional<Stamp> RadarClocks::Align(std::size_t index, Stamp stamp) {
  Watched& radar = radars_[index];
  radar.since_others.resize(radars_.size());
  ++arrivals_;
  trial_.rest = std::max(0, trial_.rest - 1);
  Compare(index, stamp - radar.offset);
  if (DiffersFromMost(index)) CorrectOffset(index);
  const Stamp aligned = stamp - radar.offset;
  radar.has_jumped = HasJumped(index, aligned);
  radar.last = aligned;
  radar.arrival_before_last = radar.arrival;
  radar.arrival = arrivals_;
  return radar.has_jumped ? std::nullopt : std::optional(aligned);
}

// A radar that has fallen silent says nothing of the time.
bool RadarClocks::IsAlive(const Watched& other, const Watched& radar) const {
  return other.last && other.arrival > radar.arrival_before_last;
}

void RadarClocks::Compare(std::size_t index, Stamp stamp) {
  Watched& radar = radars_[index];
  for (std::size_t i = 0; i < radars_.size(); ++i) {
    if (i == index || !IsAlive(radars_[i], radar)) continue;
    SinceOther& since = radar.since_others[i];
    const std::chrono::nanoseconds now = stamp - *radars_[i].last;
    // What was compared before one of the clocks was set says nothing any more.
    if (!since.empty() && std::chrono::abs(now - since.back()) > options_.max_behind) since.clear();
    if (static_cast<int>(since.size()) == options_.min_scans) since.erase(since.begin());
    since.push_back(now);
  }
}

std::optional<std::chrono::nanoseconds> RadarClocks::MinLag(std::size_t a, std::size_t b) const {
  const std::vector<SinceOther>& since_others = radars_[a].since_others;
  if (since_others.empty()) return std::nullopt;
  const SinceOther& since = since_others[b];
  if (static_cast<int>(since.size()) < options_.min_scans) return std::nullopt;
  return -*std::ranges::max_element(since);
}

std::optional<std::chrono::nanoseconds> RadarClocks::RelativeOffset(std::size_t a,
                                                                    std::size_t b) const {
  const std::optional<std::chrono::nanoseconds> a_behind = MinLag(a, b);
  const std::optional<std::chrono::nanoseconds> b_behind = MinLag(b, a);
  if (!a_behind || !b_behind) return std::nullopt;
  const std::chrono::nanoseconds most = *std::ranges::min_element(radars_[a].since_others[b]);
  const std::chrono::nanoseconds least = -*std::ranges::min_element(radars_[b].since_others[a]);
  return (most + least) / 2;
}

// Of two radars it is the one whose clock jumped, else the one that lies behind.
bool RadarClocks::DiffersFromMost(std::size_t index) const {
  int others = 0;
  int ahead = 0;
  int behind = 0;
  bool other_has_jumped = false;
  for (std::size_t i = 0; i < radars_.size(); ++i) {
    if (i == index || !RelativeOffset(index, i)) continue;
    ++others;
    if (*MinLag(index, i) > options_.max_behind) ++behind;
    if (*MinLag(i, index) > options_.max_ahead) ++ahead;
    other_has_jumped = other_has_jumped || radars_[i].has_jumped;
  }
  if (others == 1) return radars_[index].has_jumped ? ahead == 1 : behind == 1 && !other_has_jumped;
  return 2 * behind > others || 2 * ahead > others;
}

std::chrono::nanoseconds RadarClocks::AheadOfMost(std::size_t index) const {
  absl::InlinedVector<std::chrono::nanoseconds, kMaxRadars> ahead;
  for (std::size_t i = 0; i < radars_.size(); ++i) {
    if (i == index) continue;
    if (const auto of_other = RelativeOffset(index, i)) ahead.push_back(*of_other);
  }
  if (ahead.empty()) return std::chrono::nanoseconds(0);
  const auto middle = ahead.begin() + static_cast<std::ptrdiff_t>(ahead.size() / 2);
  std::nth_element(ahead.begin(), middle, ahead.end());
  return *middle;
}

std::optional<RadarClocks::Suspect> RadarClocks::Suspected() const {
  if (trial_.rest > 0) return std::nullopt;
  std::optional<Suspect> suspect;
  for (std::size_t index = 0; index < radars_.size(); ++index) {
    int others = 0, ahead = 0, behind = 0;
    for (std::size_t i = 0; i < radars_.size(); ++i) {
      if (i == index || !RelativeOffset(index, i)) continue;
      ++others;
      if (*MinLag(i, index) >= options_.min_suspected) ++ahead;
      if (*MinLag(index, i) >= options_.min_suspected) ++behind;
    }
    const int apart = std::max(ahead, behind);
    if (apart < 2 || 2 * apart < others) continue;
    const std::chrono::nanoseconds by = AheadOfMost(index);
    if (!suspect || std::chrono::abs(by) > std::chrono::abs(suspect->ahead)) suspect = {index, by};
  }
  return suspect;
}

// METHOD eq 53. Where its clock is off, the suspect fits elsewhere than the others, and the pose
// follows the one or the others: moved scans of either fit better, and not of both. Where it is
// right, neither do; where the pose is wrong along the way, both may.
bool RadarClocks::OnFits(const Suspect& suspect, std::size_t index, double as_stamped,
                         double moved) {
  if (trial_.index != suspect.index) trial_ = {.index = suspect.index};
  const double lead = moved - as_stamped;
  const double keep = options_.fit_forgetting_factor;
  if (index == suspect.index) {
    trial_.of_suspect = keep * trial_.of_suspect + lead;
    trial_.of_others *= keep;
  } else {
    trial_.of_others += lead / static_cast<double>(radars_.size() - 1);
  }
  const double both = trial_.of_suspect + trial_.of_others;
  const double is_off = std::max(trial_.of_suspect, trial_.of_others) - std::max(0.0, both);
  const double is_right = -std::max(trial_.of_suspect, trial_.of_others);
  const bool is_decided = std::max(is_off, is_right) >= options_.deciding_fit;
  if (is_decided) {
    trial_ = {.index = suspect.index, .rest = is_off > is_right ? 0 : options_.rest_scans};
  }
  return is_decided && is_off > is_right;
}

void RadarClocks::CorrectOffset(std::size_t index) {
  radars_[index].offset += AheadOfMost(index);
  ResetComparisons(index);
}

void RadarClocks::OnStep(std::size_t index, std::chrono::nanoseconds step) {
  radars_[index].offset += step;
  ResetComparisons(index);
}

// What was compared by another offset.
void RadarClocks::ResetComparisons(std::size_t index) {
  radars_[index].since_others.resize(radars_.size());
  for (std::size_t i = 0; i < radars_.size(); ++i) {
    radars_[index].since_others[i].clear();
    if (!radars_[i].since_others.empty()) radars_[i].since_others[index].clear();
  }
}

bool RadarClocks::HasJumped(std::size_t index, Stamp stamp) const {
  const Watched& radar = radars_[index];
  if (radar.last && !radar.has_jumped && stamp - *radar.last <= options_.max_lead) return false;
  bool has_others = false;
  for (std::size_t i = 0; i < radars_.size(); ++i) {
    if (i == index || !IsAlive(radars_[i], radar)) continue;
    if (stamp - *radars_[i].last <= options_.max_lead) return false;
    has_others = true;
  }
  return has_others;
}

}  // namespace dcloc
