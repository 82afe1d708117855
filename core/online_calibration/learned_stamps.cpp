#include "core/online_calibration/learned_stamps.h"

#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

// Two drives that differ by more have measured two delays.
constexpr double kSameSigmas = 3.0;
// How uncertain it is that a live radar is as late as those of the map, as a fraction of that.
constexpr double kAssumedSigmaFraction = 0.5;

// Radars of one kind differ by less than this, and velocities are often late by more.
constexpr double kMaxEarlierThanMap_s = 0.03;

// Whether its clock was never measured, so that it may be as late as a map's radars were.
bool IsVague(const RadarModel& described) {
  return described.time_offset_sigma_s > kKnownTimeOffsetSigma_s;
}

// By how much radars are less late than those of the map are assumed to be: the velocity that they
// were held against is late, and not they early.
double VelocityLate_s(const RadarDelays& delays, double assumed_late_s) {
  double sum_s = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < delays.rig().radars.size(); ++i) {
    const std::optional<ScalarEstimate> late_s = delays.Late(i);
    if (!late_s || !IsVague(delays.rig().radars[i])) continue;
    sum_s += late_s->value;
    ++count;
  }
  if (count == 0) return 0.0;
  const double earlier_s = assumed_late_s - sum_s / count;
  return earlier_s > kMaxEarlierThanMap_s ? earlier_s : 0.0;
}

// What two drives say, or the newer one where they contradict each other.
ScalarEstimate Joined(const ScalarEstimate& earlier, const ScalarEstimate& own) {
  const double sum = earlier.variance + own.variance;
  if (std::pow(own.value - earlier.value, 2) > std::pow(kSameSigmas, 2) * sum) return own;
  return {.value = (own.value * earlier.variance + earlier.value * own.variance) / sum,
          .variance = own.variance * earlier.variance / sum};
}

}  // namespace

std::span<const OptionField<LearnedStampOptions>> FieldsOf(const LearnedStampOptions& /*options*/) {
  using O = LearnedStampOptions;
  static constexpr OptionField<O> kFields[] = {
      {"measured_sigma_s", &O::measured_sigma_s, 0, 1, "only what is evident is measured"},
      {"evident_sigmas", &O::evident_sigmas, 0, 1000, "each delay is evident"},
      {"min_correction_s", &O::min_correction_s, 0, 1, "each measured delay is corrected"},
      {"contradiction_sigmas", &O::contradiction_sigmas, 0, 1000, "no description counts"},
      {"systematic_sigma_s", &O::systematic_sigma_s, 0, 1, "a drive tells all"},
      {"known_sigma_s", &O::known_sigma_s, 1e-6, 1},
      {"min_change_s", &O::min_change_s, 0, 1, "each new estimate is applied"},
  };
  return kFields;
}

absl::Status Validate(const LearnedStampOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("delays", Validate(options.delays)));
  return status;
}

// METHOD eq 68.
std::optional<ScalarEstimate> CorrectedTimeOffset(const RadarModel& described,
                                                  const ScalarEstimate& late_s,
                                                  const LearnedStampOptions& options,
                                                  double assumed_late_s) {
  const double apart_s = late_s.value - assumed_late_s;
  double measured = late_s.variance + std::pow(options.systematic_sigma_s, 2);
  double gain = 1.0;
  if (described.time_offset_sigma_s <= kKnownTimeOffsetSigma_s) {
    const double prior = std::pow(described.time_offset_sigma_s, 2);
    const bool is_contradicted =
        apart_s * apart_s > std::pow(options.contradiction_sigmas, 2) * (prior + measured);
    if (!is_contradicted) gain = prior / (prior + measured);
    measured *= gain;
  } else if (assumed_late_s != 0.0) {
    const double assumed = std::pow(kAssumedSigmaFraction * assumed_late_s, 2);
    gain = assumed / (assumed + late_s.variance);
    measured -= (1.0 - gain) * late_s.variance;
  }
  const double correction_s = assumed_late_s + gain * apart_s;
  if (assumed_late_s == 0.0 && std::abs(correction_s) < options.min_correction_s) {
    return std::nullopt;
  }
  return ScalarEstimate{.value = described.time_offset_s - correction_s, .variance = measured};
}

MeasuredStamps ToMeasuredStamps(const RadarDelays& delays, const LearnedStampOptions& options) {
  MeasuredStamps stamps{.rig = delays.rig()};
  for (std::size_t i = 0; i < stamps.rig.radars.size(); ++i) {
    RadarModel& radar = stamps.rig.radars[i];
    const std::optional<ScalarEstimate> late_s = delays.Late(i);
    if (!late_s || late_s->variance > std::pow(options.measured_sigma_s, 2)) continue;
    if (const auto corrected = CorrectedTimeOffset(radar, *late_s, options)) {
      stamps.mean_delay_s +=
          (radar.time_offset_s - corrected->value) / static_cast<double>(stamps.rig.radars.size());
      radar.time_offset_s = corrected->value;
      radar.time_offset_sigma_s = std::sqrt(corrected->variance);
    } else {
      radar.time_offset_sigma_s =
          std::min(radar.time_offset_sigma_s,
                   std::hypot(std::sqrt(late_s->variance), options.systematic_sigma_s));
    }
  }
  if (!stamps.rig.HasKnownStamps()) return {.rig = delays.rig()};
  return stamps;
}

LearnedStamps::LearnedStamps(const Rig& described, const LearnedStampOptions& options)
    : options_(options), delays_(described, options.delays), learned_(described.radars.size()) {}

void LearnedStamps::Restore(const RigKnowledge& known) {
  for (std::size_t i = 0; i < learned_.size(); ++i) {
    const RadarKnowledge* radar = known.Find(delays_.rig().radars[i].id);
    if (radar == nullptr || !radar->stamp_delay) continue;
    learned_[i].restored_late_s = {
        radar->stamp_delay->value,
        std::max(radar->stamp_delay->variance, std::pow(options_.known_sigma_s, 2))};
  }
  if (assumed_late_s_) Correct();
}

// What was restored is handed on where nothing is learned.
void LearnedStamps::AddTo(RigKnowledge& known) const {
  for (std::size_t i = 0; i < learned_.size(); ++i) {
    const std::optional<ScalarEstimate> late_s = Late(i);
    if (late_s && IsMeasured(*late_s)) known.Of(delays_.rig().radars[i].id).stamp_delay = late_s;
  }
}

void LearnedStamps::Begin(double assumed_late_s) {
  assumed_late_s_ = assumed_late_s;
  Correct();
}

double LearnedStamps::OnScan(Stamp stamp, std::size_t index, const Scan& scan, bool is_sound) {
  if (!assumed_late_s_) return 0.0;
  const bool is_doubted = delays_.rig().radars[index].time_offset_sigma_s > 0.0;
  return delays_.OnScan(stamp, index, scan, is_sound && is_doubted) ? Correct() : 0.0;
}

std::optional<ScalarEstimate> LearnedStamps::Late(std::size_t index) const {
  std::optional<ScalarEstimate> own = delays_.Late(index);
  if (own && assumed_late_s_ && IsVague(delays_.rig().radars[index])) {
    own->value += VelocityLate_s(delays_, *assumed_late_s_);
  }
  const std::optional<ScalarEstimate>& restored = learned_[index].restored_late_s;
  if (!own || !restored) return own ? own : restored;
  return Joined(*restored, *own);
}

bool LearnedStamps::IsMeasured(const ScalarEstimate& late_s) const {
  return late_s.variance <= std::pow(options_.measured_sigma_s, 2) ||
         std::pow(late_s.value, 2) > std::pow(options_.evident_sigmas, 2) * late_s.variance;
}

std::optional<ScalarEstimate> LearnedStamps::Offset(std::size_t index) const {
  const RadarModel& described = delays_.rig().radars[index];
  const double assumed_late_s = IsVague(described) ? *assumed_late_s_ : 0.0;
  const std::optional<ScalarEstimate> late_s = Late(index);
  if (late_s && (assumed_late_s != 0.0 || IsMeasured(*late_s))) {
    return CorrectedTimeOffset(described, *late_s, options_, assumed_late_s);
  }
  if (assumed_late_s == 0.0) return std::nullopt;
  return ScalarEstimate{.value = described.time_offset_s - assumed_late_s,
                        .variance = std::pow(described.time_offset_sigma_s, 2)};
}

double LearnedStamps::Correct() {
  double change_s = 0.0;
  for (std::size_t i = 0; i < learned_.size(); ++i) {
    std::optional<ScalarEstimate>& applied = learned_[i].time_offset_s;
    const std::optional<ScalarEstimate> offset_s = Offset(i);
    const double described_s = delays_.rig().radars[i].time_offset_s;
    const double before_s = applied ? applied->value : described_s;
    const double now_s = offset_s ? offset_s->value : described_s;
    if (applied && offset_s && std::abs(now_s - before_s) < options_.min_change_s) {
      applied->variance = offset_s->variance;
      continue;
    }
    applied = offset_s;
    change_s = std::max(change_s, std::abs(now_s - before_s));
  }
  return change_s;
}

}  // namespace dcloc
