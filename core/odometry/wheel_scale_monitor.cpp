#include "core/odometry/wheel_scale_monitor.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dcloc {

std::span<const OptionField<WheelScaleMonitorOptions>> FieldsOf(
    const WheelScaleMonitorOptions& /*options*/) {
  using O = WheelScaleMonitorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"span_ms", &O::span, 1, 1e5},
      {"max_gap_ms", &O::max_gap, 1, 1e5},
      {"min_reading_count", &O::min_reading_count, 1, 1000},
      {"min_speed_mps", &O::min_speed_mps, 0.1, 100},
      {"speed_sigma_mps", &O::speed_sigma_mps, 1e-6, 100},
      {"reading_sigma_mps", &O::reading_sigma_mps, 1e-6, 100},
      {"speed_sigma_fraction", &O::speed_sigma_fraction, 0, 1, "the deviation is constant"},
      {"delay_sigma_s", &O::delay_sigma_s, 0, 10, "the clocks agree"},
      {"usual_span_count", &O::usual_span_count, 1, 100'000},
      {"min_usual_span_count", &O::min_usual_span_count, 1, 100'000},
      {"usual_sigmas", &O::usual_sigmas, 1e-3, 1e6},
      {"min_change", &O::min_change, 0, 0.5, "each change counts"},
      {"max_change", &O::max_change, 0, 0.5, "the scale does not change at once"},
      {"change_sigma_fraction", &O::change_sigma_fraction, 0, 10, "a change is exact"},
  };
  return kFields;
}

absl::Status Validate(const WheelScaleMonitorOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("change", Validate(options.change)));
  return status;
}

std::optional<WheelScaleChange> WheelScaleMonitor::OnSpeeds(Stamp stamp, double wheels_mps,
                                                            double doppler_mps) {
  std::optional<WheelScaleChange> change;
  if (span_ && stamp - span_->end > options_.max_gap) span_.reset();
  if (span_ && stamp - span_->begin >= options_.span) {
    change = OnSpan(*std::exchange(span_, std::nullopt));
  }
  if (!span_) span_ = Span{.begin = stamp, .end = stamp, .first_wheels_mps = wheels_mps};
  span_->end = stamp;
  span_->last_wheels_mps = wheels_mps;
  span_->wheels_sum_mps += wheels_mps;
  span_->doppler_sum_mps += doppler_mps;
  ++span_->count;
  return change;
}

std::optional<WheelScaleChange> WheelScaleMonitor::OnSpan(const Span& span) {
  if (span.count < options_.min_reading_count) return std::nullopt;
  if (std::abs(span.wheels_sum_mps) < span.count * options_.min_speed_mps) {
    ForgetUnusual();
    return std::nullopt;
  }
  const double ratio = span.doppler_sum_mps / span.wheels_sum_mps;
  if (usual_count_ < options_.min_usual_span_count) {
    Learn(ratio, VarianceOf(span));
    return std::nullopt;
  }
  // Wheels that slip say nothing of their scale, nor do the spans before and after.
  if (std::abs(ratio / usual_ratio_ - 1.0) > options_.max_change) {
    ForgetUnusual();
    return std::nullopt;
  }
  const ScalarEstimate deviation{ratio / usual_ratio_ - 1.0, VarianceOf(span)};
  if (std::pow(deviation.value, 2) <= std::pow(options_.usual_sigmas, 2) * deviation.variance)
    Learn(ratio, deviation.variance);
  const bool is_usual = std::pow(deviation.value, 2) <= deviation.variance;
  unusual_distance_m_ = is_usual ? 0.0
                                 : unusual_distance_m_ + std::abs(span.wheels_sum_mps) /
                                                             span.count * SecondsOf(options_.span);
  std::optional<ScalarEstimate> change = change_.OnDeviation(deviation, 1.0);
  if (!change || std::abs(change->value) < options_.min_change) return std::nullopt;
  usual_ratio_ *= 1.0 + change->value;
  change->variance += std::pow(options_.change_sigma_fraction * change->value, 2);
  return WheelScaleChange{*change, std::exchange(unusual_distance_m_, 0.0)};
}

std::optional<double> WheelScaleMonitor::UnconfirmedChange() const {
  return change_.UnconfirmedChange();
}

bool WheelScaleMonitor::IsUnusual(double wheels_mps, double doppler_mps,
                                  double acceleration_mps2) const {
  if (usual_count_ < options_.min_usual_span_count) return false;
  const double expected_mps = usual_ratio_ * wheels_mps;
  const double variance = std::pow(options_.reading_sigma_mps, 2) +
                          std::pow(options_.speed_sigma_fraction * expected_mps, 2) +
                          std::pow(options_.delay_sigma_s * acceleration_mps2, 2);
  return std::pow(doppler_mps - expected_mps, 2) > std::pow(options_.usual_sigmas, 2) * variance;
}

double WheelScaleMonitor::VarianceOf(const Span& span) const {
  const double speed_mps = std::abs(span.wheels_sum_mps) / span.count;
  const double delayed_mps = options_.delay_sigma_s *
                             (span.last_wheels_mps - span.first_wheels_mps) /
                             std::max(1e-3, SecondsOf(span.end - span.begin));
  return (std::pow(options_.speed_sigma_mps, 2) + std::pow(delayed_mps, 2)) /
             std::pow(speed_mps, 2) +
         std::pow(options_.speed_sigma_fraction, 2);
}

void WheelScaleMonitor::Learn(double ratio, double variance) {
  usual_count_ = std::min(usual_count_ + 1, options_.usual_span_count);
  usual_ratio_ += (ratio - usual_ratio_) / usual_count_;
  usual_variance_ += (variance - usual_variance_) / usual_count_;
}

std::optional<ScalarEstimate> WheelScaleMonitor::TakeScale() {
  if (has_told_scale_ || usual_count_ < options_.min_usual_span_count) return std::nullopt;
  has_told_scale_ = true;
  return ScalarEstimate{usual_ratio_, usual_variance_};
}

void WheelScaleMonitor::ForgetRatio() {
  OnUnsound();
  usual_ratio_ = 1.0;
  usual_variance_ = 0.0;
  usual_count_ = 0;
}

void WheelScaleMonitor::OnUnsound() {
  span_.reset();
  ForgetUnusual();
}

void WheelScaleMonitor::ForgetUnusual() {
  unusual_distance_m_ = 0.0;
  change_.Reset();
}

}  // namespace dcloc
