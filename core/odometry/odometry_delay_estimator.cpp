#include "core/odometry/odometry_delay_estimator.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/radar/stamp.h"

namespace dcloc {
namespace {

// However fast scans come, and whatever their stamps.
constexpr std::ptrdiff_t kMaxSamples = 1024;

}  // namespace

std::span<const OptionField<OdometryDelayOptions>> FieldsOf(
    const OdometryDelayOptions& /*options*/) {
  using O = OdometryDelayOptions;
  static constexpr OptionField<O> kFields[] = {
      {"step_ms", &O::step, 5, 1000},
      {"earliest_steps", &O::earliest_steps, 1, 50},
      {"latest_steps", &O::latest_steps, 1, 50},
      {"smoothing_ms", &O::smoothing, 1, 1000},
      {"interval_ms", &O::interval, 0, 1e4, "all moments are compared"},
      {"time_constant_ms", &O::time_constant, 100, 1e7},
      {"min_log_likelihood", &O::min_log_likelihood, 0, 1e9, "the best delay is accepted"},
      {"min_moment_count", &O::min_moment_count, 3, 1'000'000},
      {"min_delay_ms", &O::min_delay, 0, 1e4, "each delay is compensated"},
      {"speed_floor_mps", &O::speed_floor_mps, 1e-6, 100},
      {"prior_sigma_s", &O::prior_sigma_s, 1e-6, 10},
      {"yaw_rate_floor_radps", &O::yaw_rate_floor_radps, 1e-9, 10},
  };
  return kFields;
}

absl::Status Validate(const OdometryDelayOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

OdometryDelayEstimator::OdometryDelayEstimator(const OdometryDelayOptions& options)
    : options_(options) {
  const int candidate_count = options.earliest_steps + options.latest_steps + 1;
  candidates_.resize(static_cast<std::size_t>(candidate_count));
}

void OdometryDelayEstimator::Restore(const ScalarEstimate& delay_s) {
  const double last = SecondsOf(DelayOf(static_cast<int>(candidates_.size()) - 1));
  if (delay_s.value <= SecondsOf(DelayOf(0)) || delay_s.value >= last) return;
  prior_s_ = {delay_s.value, std::max(delay_s.variance, std::pow(options_.prior_sigma_s, 2))};
  prior_weight_ = 1.0;
  if (delay_s.value >= SecondsOf(options_.min_delay)) delay_s_ = prior_s_;
}

void OdometryDelayEstimator::OnReported(Stamp stamp, double speed_mps, double yaw_rate_radps) {
  reported_.push_back({stamp, speed_mps, yaw_rate_radps});
  const std::chrono::nanoseconds latest =
      DelayOf(static_cast<int>(candidates_.size()) - 1) + options_.smoothing;
  auto waiting = waiting_.begin();
  for (; waiting != waiting_.end() && waiting->stamp + latest <= stamp; ++waiting) {
    Compare(*waiting);
  }
  waiting_.erase(waiting_.begin(), waiting);
  const Stamp oldest = (waiting_.empty() ? stamp : waiting_.front().stamp) -
                       options_.earliest_steps * options_.step - options_.smoothing;
  auto kept = std::ranges::lower_bound(reported_, oldest, {}, &Sample::stamp);
  if (reported_.end() - kept > kMaxSamples) kept = reported_.end() - kMaxSamples;
  reported_.erase(reported_.begin(), kept);
}

void OdometryDelayEstimator::OnDoppler(Stamp stamp, double speed_mps, double yaw_rate_radps) {
  if (last_doppler_ && stamp - *last_doppler_ < options_.interval) return;
  last_doppler_ = stamp;
  waiting_.push_back({stamp, speed_mps, yaw_rate_radps});
  if (std::ssize(waiting_) > kMaxSamples) waiting_.erase(waiting_.begin());
}

// The mean of what was reported around `stamp`; nothing where that is not all around it.
std::optional<OdometryDelayEstimator::Sample> OdometryDelayEstimator::ReportedAt(
    Stamp stamp) const {
  if (reported_.empty() || reported_.front().stamp > stamp || reported_.back().stamp < stamp) {
    return std::nullopt;
  }
  const auto first =
      std::ranges::lower_bound(reported_, stamp - options_.smoothing, {}, &Sample::stamp);
  const double width_s = SecondsOf(options_.smoothing);
  Sample mean{stamp, 0.0, 0.0};
  double sum = 0.0;
  double offset_s = 0.0;
  for (auto sample = first; sample != reported_.end(); ++sample) {
    const double apart_s = SecondsOf(sample->stamp - stamp);
    const double weight = 1.0 - std::abs(apart_s) / width_s;
    if (weight <= 0.0) {
      if (apart_s > 0.0) break;
      continue;
    }
    mean.speed_mps += weight * sample->speed_mps;
    mean.yaw_rate_radps += weight * sample->yaw_rate_radps;
    offset_s += weight * apart_s;
    sum += weight;
  }
  // A gap beside the moment would make the mean one of another moment.
  if (sum < 1.0 || std::abs(offset_s) > 0.2 * width_s * sum) return std::nullopt;
  mean.speed_mps /= sum;
  mean.yaw_rate_radps /= sum;
  return mean;
}

// All candidates take the moment in, or none: their likelihoods are of the same data.
void OdometryDelayEstimator::Compare(const Sample& doppler) {
  reported_then_.clear();
  for (int i = 0; i < static_cast<int>(candidates_.size()); ++i) {
    const std::optional<Sample> reported = ReportedAt(doppler.stamp + DelayOf(i));
    if (!reported) return;
    reported_then_.push_back(*reported);
  }
  const double keep = last_compared_ ? std::exp(-SecondsOf(doppler.stamp - *last_compared_) /
                                                SecondsOf(options_.time_constant))
                                     : 1.0;
  last_compared_ = doppler.stamp;
  prior_weight_ *= keep;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    candidates_[i].speed.Add(keep, reported_then_[i].speed_mps, doppler.speed_mps);
    candidates_[i].yaw_rate.Add(keep, reported_then_[i].yaw_rate_radps, doppler.yaw_rate_radps);
  }
  ++moment_count_;
  if (moment_count_ >= options_.min_moment_count) Decide();
}

// METHOD eq 45: the noise is unknown, so the residuals' own variance stands for it. A prior
// weighs no more than what a delay needs to be accepted, and less as the drive goes on.
double OdometryDelayEstimator::Cost(std::size_t index, double speed_count,
                                    double yaw_rate_count) const {
  const Candidate& candidate = candidates_[index];
  double prior = 0.0;
  if (prior_s_) {
    const double apart_s = SecondsOf(DelayOf(static_cast<int>(index))) - prior_s_->value;
    prior = prior_weight_ *
            std::min(options_.min_log_likelihood, 0.5 * apart_s * apart_s / prior_s_->variance);
  }
  const double speed = candidate.speed.ResidualVariance() + std::pow(options_.speed_floor_mps, 2);
  const double yaw_rate =
      candidate.yaw_rate.ResidualVariance() + std::pow(options_.yaw_rate_floor_radps, 2);
  return prior + 0.5 * (speed_count * std::log(speed) + yaw_rate_count * std::log(yaw_rate));
}

std::size_t OdometryDelayEstimator::LeastCost(double speed_count, double yaw_rate_count) const {
  std::size_t best = 0;
  double least = Cost(0, speed_count, yaw_rate_count);
  for (std::size_t i = 1; i < candidates_.size(); ++i) {
    const double cost = Cost(i, speed_count, yaw_rate_count);
    if (cost >= least) continue;
    least = cost;
    best = i;
  }
  return best;
}

void OdometryDelayEstimator::Decide() {
  const double count = candidates_.front().speed.weight;
  const Candidate& likeliest = candidates_[LeastCost(count, count)];
  const double speed_count = count * likeliest.speed.IndependentFraction();
  const double yaw_rate_count = count * likeliest.yaw_rate.IndependentFraction();
  const std::size_t best = LeastCost(speed_count, yaw_rate_count);
  const auto cost = [&](std::size_t i) { return Cost(i, speed_count, yaw_rate_count); };
  const double gain = cost(static_cast<std::size_t>(options_.earliest_steps)) - cost(best);
  const double needed = delay_s_ ? 0.5 : 1.0;
  delay_s_.reset();
  // A minimum at either end may belong to a delay beyond those that are compared.
  if (best == 0 || best + 1 == candidates_.size() || gain < needed * options_.min_log_likelihood) {
    return;
  }
  const double before = cost(best - 1);
  const double after = cost(best + 1);
  const double bend = std::max(1e-9, before - 2.0 * cost(best) + after);
  const double step_s = SecondsOf(options_.step);
  const double delay_s = SecondsOf(DelayOf(static_cast<int>(best))) +
                         step_s * std::clamp(0.5 * (before - after) / bend, -0.5, 0.5);
  // What seems early is scans that are stamped late, by map and vehicle alike.
  if (delay_s < needed * SecondsOf(options_.min_delay)) return;
  delay_s_ = {.value = delay_s, .variance = step_s * step_s / bend};
}

void OdometryDelayEstimator::Regression::Add(double keep, double x_new, double y_new) {
  const auto add = [keep](double& sum, double value) { sum = keep * sum + value; };
  if (weight == 0.0) x_last = x_new, y_last = y_new;
  add(weight, 1.0);
  add(x, x_new);
  add(y, y_new);
  add(xx, x_new * x_new);
  add(xy, x_new * y_new);
  add(yy, y_new * y_new);
  add(xx_next, x_new * x_last);
  add(xy_next, 0.5 * (x_new * y_last + x_last * y_new));
  add(yy_next, y_new * y_last);
  x_last = x_new;
  y_last = y_new;
}

double OdometryDelayEstimator::Regression::Slope() const {
  const double variance_x = xx / weight - std::pow(x / weight, 2);
  if (variance_x < 1e-12) return 0.0;
  return (xy / weight - x * y / (weight * weight)) / variance_x;
}

double OdometryDelayEstimator::Regression::ResidualVariance() const {
  const double covariance = xy / weight - x * y / (weight * weight);
  return std::max(0.0, yy / weight - std::pow(y / weight, 2) - Slope() * covariance);
}

double OdometryDelayEstimator::Regression::IndependentFraction() const {
  const double slope = Slope();
  const double variance = ResidualVariance();
  if (variance <= 0.0) return 1.0;
  const double next = (yy_next - 2.0 * slope * xy_next + slope * slope * xx_next) / weight -
                      std::pow((y - slope * x) / weight, 2);
  const double correlation = std::clamp(next / variance, 0.0, 0.95);
  return (1.0 - correlation) / (1.0 + correlation);
}

}  // namespace dcloc
