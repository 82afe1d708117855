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

void RadarClocks::CorrectOffset(std::size_t index) {
  absl::InlinedVector<std::chrono::nanoseconds, kMaxRadars> ahead;
  for (std::size_t i = 0; i < radars_.size(); ++i) {
    if (i == index) continue;
    if (const auto of_other = RelativeOffset(index, i)) ahead.push_back(*of_other);
  }
  const auto middle = ahead.begin() + static_cast<std::ptrdiff_t>(ahead.size() / 2);
  std::nth_element(ahead.begin(), middle, ahead.end());
  radars_[index].offset += *middle;
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
