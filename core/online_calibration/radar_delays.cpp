#include "core/online_calibration/radar_delays.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Cholesky"
#include "core/radar/stamp.h"

namespace dcloc {
namespace {

// However fast scans come, and whatever their stamps.
constexpr std::ptrdiff_t kMaxReported = 1024;
constexpr std::size_t kMaxWaiting = 1024;
// Moments from which a regression has a meaning.
constexpr double kMinMoments = 40.0;
// Moments that a regression contradicts by more are left out, while it is no better than this.
constexpr double kOutlierSigmas = 3.5;
constexpr double kMinSigma_mps = 0.03;
// Of Doppler's speed on the reported one; noise of a steady drive has none near to 1.
constexpr double kMinSlope = 0.5;
constexpr double kMaxSlope = 2.0;

}  // namespace

std::span<const OptionField<RadarDelayOptions>> FieldsOf(const RadarDelayOptions& /*options*/) {
  using O = RadarDelayOptions;
  static constexpr OptionField<O> kFields[] = {
      {"step_ms", &O::step, 5, 1000},
      {"max_gap_ms", &O::max_gap, 1, 1e4},
      {"interval_ms", &O::interval, 0, 1e4, "all moments are compared"},
      {"time_constant_ms", &O::time_constant, 100, 1e8},
      {"update_interval_ms", &O::update_interval, 0, 1e6, "each scan computes the delays"},
      {"min_speed_mps", &O::min_speed_mps, 0, 100, "a vehicle at rest takes part"},
      {"block_ms", &O::block, 1, 1e6},
      {"min_block_count", &O::min_block_count, 2, 1'000'000},
      {"max_residual_mps", &O::max_residual_mps, 1e-6, 100},
      {"sigma_floor_s", &O::sigma_floor_s, 0, 1, "a delay is as certain as the drive tells"},
  };
  return kFields;
}

absl::Status Validate(const RadarDelayOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("speed", Validate(options.speed)));
  return status;
}

RadarDelays::RadarDelays(Rig described, const RadarDelayOptions& options)
    : options_(options),
      described_(std::move(described)),
      speed_(options.speed),
      radars_(described_.radars.size()) {}

double RadarDelays::StepSeconds() const { return SecondsOf(options_.step); }

bool RadarDelays::OnScan(Stamp stamp, std::size_t index, const Scan& scan, bool is_sound) {
  if (!scan.ego_velocity) return false;
  const EgoVelocity& reported = *scan.ego_velocity;
  AddReported(stamp, reported);
  Radar& radar = radars_[index];
  const RadarModel& model = described_.radars[index];
  if (is_sound && std::abs(reported.linear_mps.x()) >= options_.min_speed_mps &&
      !(radar.last && stamp - *radar.last < options_.interval)) {
    if (const auto speed_mps = speed_.Of(scan, model, reported)) {
      radar.last = stamp;
      const auto offset = std::chrono::round<std::chrono::nanoseconds>(
          std::chrono::duration<double>(model.time_offset_s));
      if (waiting_.size() < kMaxWaiting) waiting_.push_back({stamp + offset, index, *speed_mps});
    }
  }
  AddMoments();
  if (updated_ && stamp - *updated_ < options_.update_interval) return false;
  updated_ = stamp;
  Update();
  return true;
}

void RadarDelays::OnDiscontinuity() {
  reported_.clear();
  waiting_.clear();
  updated_.reset();
  for (Radar& radar : radars_) {
    radar.last.reset();
    radar.last_added.reset();
    radar.block_begin.reset();
    radar.block_score = 0.0;
  }
}

void RadarDelays::AddReported(Stamp stamp, const EgoVelocity& velocity) {
  Reported next{.stamp = stamp,
                .speed_mps = velocity.linear_mps.x(),
                .yaw_rate_radps = velocity.angular_radps.z(),
                .distance_m = 0.0,
                .turn_rad = 0.0};
  if (!reported_.empty()) {
    const Reported& last = reported_.back();
    if (stamp <= last.stamp) return;
    if (stamp - last.stamp > options_.max_gap) {
      OnDiscontinuity();
    } else {
      const double duration_s = SecondsOf(stamp - last.stamp);
      next.distance_m = last.distance_m + 0.5 * duration_s * (last.speed_mps + next.speed_mps);
      next.turn_rad =
          last.turn_rad + 0.5 * duration_s * (last.yaw_rate_radps + next.yaw_rate_radps);
    }
  }
  reported_.push_back(next);
}

void RadarDelays::AddMoments() {
  if (reported_.empty()) return;
  const std::chrono::nanoseconds reach = (kSteps + kMargin) * options_.step;
  // Described offsets may put moments out of order.
  std::erase_if(waiting_, [&](const Moment& moment) {
    if (moment.stamp + reach > reported_.back().stamp) return false;
    if (moment.stamp - reach >= reported_.front().stamp) Add(moment);
    return true;
  });
  Stamp oldest = reported_.back().stamp;
  for (const Moment& moment : waiting_) oldest = std::min(oldest, moment.stamp);
  for (const RadarModel& model : described_.radars) {
    const auto ahead = std::chrono::round<std::chrono::nanoseconds>(
        std::chrono::duration<double>(std::max(0.0, -model.time_offset_s)));
    oldest = std::min(oldest, reported_.back().stamp - ahead);
  }
  oldest -= reach;
  // One from before it stays, for the interpolation.
  auto kept = std::ranges::lower_bound(reported_, oldest, {}, &Reported::stamp);
  if (kept != reported_.begin()) --kept;
  if (reported_.end() - kept > kMaxReported) kept = reported_.end() - kMaxReported;
  reported_.erase(reported_.begin(), kept);
}

// METHOD eq 66. Reported velocities are averaged over four steps around a moment: a mean of the
// line through them has as much noise wherever it lies between two of them.
void RadarDelays::Add(const Moment& moment) {
  constexpr int kBounds = kCandidates + 2 * kMargin;
  std::array<double, kBounds> distance_m;
  std::array<double, kBounds> turn_rad;
  Stamp at = moment.stamp - (kSteps + kMargin) * options_.step;
  auto after = std::ranges::upper_bound(reported_, at, {}, &Reported::stamp);
  for (int i = 0; i < kBounds; ++i, at += options_.step) {
    const auto bound = static_cast<std::size_t>(i);
    while (after != reported_.end() && after->stamp < at) ++after;
    if (after == reported_.end() || after == reported_.begin()) {
      const Reported& edge = after == reported_.end() ? reported_.back() : reported_.front();
      distance_m[bound] = edge.distance_m + SecondsOf(at - edge.stamp) * edge.speed_mps;
      turn_rad[bound] = edge.turn_rad + SecondsOf(at - edge.stamp) * edge.yaw_rate_radps;
      continue;
    }
    const Reported& before = *(after - 1);
    const double width_s = SecondsOf(after->stamp - before.stamp);
    const double since_s = SecondsOf(at - before.stamp);
    const double half_square = 0.5 * since_s * since_s / width_s;
    distance_m[bound] = before.distance_m + since_s * before.speed_mps +
                        half_square * (after->speed_mps - before.speed_mps);
    turn_rad[bound] = before.turn_rad + since_s * before.yaw_rate_radps +
                      half_square * (after->yaw_rate_radps - before.yaw_rate_radps);
  }
  const double per_width = 1.0 / (2 * kMargin * StepSeconds());
  const double y = moment.speed_mps;
  std::array<double, kCandidates> speeds;
  std::array<double, kCandidates> yaw_rates;
  for (std::size_t i = 0; i < kCandidates; ++i) {
    // Candidate i is a delay of i - kSteps steps: what was reported so long before.
    const std::size_t low = kCandidates - 1 - i;
    const std::size_t high = low + std::size_t{2} * kMargin;
    speeds[i] = per_width * (distance_m[high] - distance_m[low]);
    yaw_rates[i] = per_width * (turn_rad[high] - turn_rad[low]);
  }
  Radar& radar = radars_[moment.index];
  const auto best = static_cast<std::size_t>(radar.best);
  const double residual = y - radar.fit.offset - radar.fit.per_speed * speeds[best] -
                          radar.fit.per_yaw_rate * yaw_rates[best];
  // A mover's speed would weigh as many as its square says.
  if (radar.is_solved &&
      std::abs(residual) >
          kOutlierSigmas * std::max(kMinSigma_mps, std::sqrt(radar.fit.variance))) {
    return;
  }
  const double age_s =
      radar.last_added ? std::max(0.0, SecondsOf(moment.stamp - *radar.last_added)) : 0.0;
  const double keep = std::exp(-age_s / SecondsOf(options_.time_constant));
  radar.last_added = moment.stamp;
  for (std::size_t i = 0; i < kCandidates; ++i) {
    const double v = speeds[i];
    const double w = yaw_rates[i];
    Sums& sums = radar.sums[i];
    const auto add = [keep](double& sum, double value) { sum = keep * sum + value; };
    add(sums.n, 1.0);
    add(sums.v, v);
    add(sums.w, w);
    add(sums.y, y);
    add(sums.vv, v * v);
    add(sums.vw, v * w);
    add(sums.ww, w * w);
    add(sums.vy, v * y);
    add(sums.wy, w * y);
    add(sums.yy, y * y);
  }
  // How far the moment alone would move the delay that was found.
  radar.score_square *= keep * keep;
  radar.block_score *= keep;
  if (!radar.is_solved || radar.best == 0 || radar.best == kCandidates - 1) return;
  const double slope =
      radar.fit.per_speed * 0.5 * (speeds[best + 1] - speeds[best - 1]) / StepSeconds();
  if (!radar.block_begin) radar.block_begin = moment.stamp;
  if (moment.stamp - *radar.block_begin >= options_.block) {
    radar.score_square += radar.block_score * radar.block_score;
    ++radar.block_count;
    radar.block_score = 0.0;
    radar.block_begin = moment.stamp;
  }
  radar.block_score += slope * (residual - slope * radar.vertex_steps * StepSeconds());
}

RadarDelays::Fit RadarDelays::FitOf(const Sums& sums) {
  constexpr double kSpeedRidge = 1e-4;
  constexpr double kYawRateRidge = 1e-6;
  const double per_n = 1.0 / sums.n;
  const double v = sums.v * per_n;
  const double w = sums.w * per_n;
  const double y = sums.y * per_n;
  Eigen::Matrix2d normal;
  normal(0, 0) = sums.vv * per_n - v * v + kSpeedRidge;
  normal(0, 1) = normal(1, 0) = sums.vw * per_n - v * w;
  normal(1, 1) = sums.ww * per_n - w * w + kYawRateRidge;
  const Eigen::Vector2d right(sums.vy * per_n - v * y, sums.wy * per_n - w * y);
  const Eigen::Vector2d slopes = normal.ldlt().solve(right);
  return {.offset = y - slopes.dot(Eigen::Vector2d(v, w)),
          .per_speed = slopes(0),
          .per_yaw_rate = slopes(1),
          .variance = std::max(0.0, sums.yy * per_n - y * y - slopes.dot(right))};
}

void RadarDelays::Update() {
  for (Radar& radar : radars_) Solve(radar);
}

// METHOD eq 66.
void RadarDelays::Solve(Radar& radar) const {
  radar.delay_s.reset();
  radar.is_solved = false;
  const double n = radar.sums.front().n;
  if (n < kMinMoments) return;
  std::array<Fit, kCandidates> fits;
  std::ranges::transform(radar.sums, fits.begin(), FitOf);
  const auto best =
      static_cast<std::size_t>(std::ranges::min_element(fits, {}, &Fit::variance) - fits.begin());
  radar.best = static_cast<int>(best);
  radar.fit = fits[best];
  if (best == 0 || best + 1 == fits.size()) return;
  const double before = fits[best - 1].variance;
  const double after = fits[best + 1].variance;
  const double bend = before - 2.0 * radar.fit.variance + after;
  if (!(bend > 0.0)) return;
  radar.vertex_steps = std::clamp(0.5 * (before - after) / bend, -0.5, 0.5);
  radar.is_solved = true;
  if (radar.block_count < options_.min_block_count || !(radar.fit.per_speed > kMinSlope) ||
      !(radar.fit.per_speed < kMaxSlope) ||
      radar.fit.variance > std::pow(options_.max_residual_mps, 2)) {
    return;
  }
  const double step_s = StepSeconds();
  const double square_sum = n * 0.5 * bend / (step_s * step_s);  // of the accelerations
  // Few blocks may agree by chance.
  const double few = radar.block_count / (radar.block_count - options_.min_block_count / 2.0);
  const double variance = few * radar.score_square / (square_sum * square_sum);
  radar.delay_s = {
      .value = (static_cast<double>(radar.best - kSteps) + radar.vertex_steps) * step_s,
      .variance = variance + std::pow(options_.sigma_floor_s, 2)};
}

// METHOD eq 67. What is stamped on arrival is late and never early: where Doppler seems early
// against the reported velocity, that is late itself, by as much as the earliest radar shows.
std::optional<ScalarEstimate> RadarDelays::Late(std::size_t index) const {
  const std::optional<ScalarEstimate>& own = radars_[index].delay_s;
  if (!own) return std::nullopt;
  ScalarEstimate least = *own;
  for (const Radar& radar : radars_) {
    if (radar.delay_s && radar.delay_s->value < least.value) least = *radar.delay_s;
  }
  if (least.value >= 0.0) return own;
  return ScalarEstimate{.value = own->value - least.value,
                        .variance = own->variance + least.variance};
}

}  // namespace dcloc
