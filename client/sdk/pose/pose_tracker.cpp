#include "client/sdk/pose/pose_tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::client {
namespace {

/// A stamp that lies so far before the newest one says that the clock was set.
constexpr std::int64_t kClockSet_ns = 1'000'000'000;
constexpr std::int64_t kMinVelocityInterval_ns = 10'000'000;
/// Readings further apart are not averaged over: the velocity between them is told by nobody.
constexpr double kMaxInterval_s = 0.1;
constexpr std::size_t kMaxAnchors = 64;
constexpr std::size_t kMaxVelocities = 96;
static_assert(kMaxAnchors + kMaxVelocities <= PublishedTimeline::kMaxSegments);

std::int64_t Nanoseconds(std::chrono::milliseconds duration) {
  return std::chrono::nanoseconds(duration).count();
}

bool HasPoseInMap(const v1::LocalizationResult& result) {
  return result.pose().covariance_size() == 36 &&
         (result.state() == v1::LOCALIZATION_STATE_TRACKING ||
          result.state() == v1::LOCALIZATION_STATE_DEAD_RECKONING ||
          result.state() == v1::LOCALIZATION_STATE_LOST);
}

Anchor AnchorOf(const v1::LocalizationResult& result) {
  const v1::Vector3& t = result.pose().pose().translation_m();
  const v1::Quaternion& q = result.pose().pose().rotation();
  Anchor anchor{.stamp_ns = result.stamp_ns(),
                .T_map_vehicle = {{t.x(), t.y(), t.z()}, {q.w(), q.x(), q.y(), q.z()}},
                .covariance = {},
                .state = result.state()};
  std::ranges::copy(result.pose().covariance(), anchor.covariance.begin());
  return anchor;
}

bool IsFaulty(const v1::SourceHealth& health) {
  return health.fault() != v1::SOURCE_FAULT_UNSPECIFIED && health.fault() != v1::SOURCE_FAULT_NONE;
}

/// Of a velocity that came without a covariance.
Vector6 UsualVariances(const Vector6& velocity, double scale_sigma, const PoseOptions& options) {
  Vector6 variances;
  for (std::size_t i = 0; i < variances.size(); ++i) {
    const double scaled = i < 3 ? scale_sigma * velocity[i] : 0.0;
    const double sigma = i < 3 ? options.velocity_sigma_mps : options.turn_rate_sigma_radps;
    variances[i] = sigma * sigma + scaled * scaled;
  }
  return variances;
}

absl::StatusOr<GivenVelocity> VelocityOf(std::int64_t stamp_ns, const v1::EgoVelocity& message) {
  if (stamp_ns <= 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("stamp_ns is ", stamp_ns, "; it must be positive"));
  }
  const v1::Vector3& v = message.linear_mps();
  const v1::Vector3& w = message.angular_radps();
  GivenVelocity given{.stamp_ns = stamp_ns, .velocity = {v.x(), v.y(), v.z(), w.x(), w.y(), w.z()}};
  if (!std::ranges::all_of(given.velocity, [](double x) { return std::isfinite(x); })) {
    return absl::InvalidArgumentError("ego_velocity has a value that is not finite");
  }
  const int count = message.covariance_size();
  if (count != 0 && count != 36) {
    return absl::InvalidArgumentError(
        absl::StrCat("ego_velocity.covariance has ", count, " values; it must have 36 or none"));
  }
  given.has_usual_variances = count == 0;
  for (int i = 0; i < 6 && count == 36; ++i) {
    const double variance = message.covariance(7 * i);
    if (!std::isfinite(variance) || variance < 0.0) {
      return absl::InvalidArgumentError(absl::StrCat("ego_velocity.covariance[", 7 * i, "] is ",
                                                     variance, "; it must not be negative"));
    }
    given.variances[static_cast<std::size_t>(i)] = variance;
  }
  return given;
}

/// Puts `item` where its stamp belongs, in place of one that has the same.
template <typename T>
void Insert(const T& item, std::vector<T>& items) {
  const auto place =
      std::ranges::lower_bound(items, item.stamp_ns, std::ranges::less(), &T::stamp_ns);
  if (place != items.end() && place->stamp_ns == item.stamp_ns) {
    *place = item;
  } else {
    items.insert(place, item);
  }
}

/// Forgets what is older, but for the newest of that.
template <typename T>
void ForgetBefore(std::int64_t stamp_ns, std::size_t max_count, std::vector<T>& items) {
  auto first = std::ranges::upper_bound(items, stamp_ns, std::ranges::less(), &T::stamp_ns);
  if (first != items.begin()) --first;
  if (static_cast<std::size_t>(items.end() - first) > max_count) {
    first = items.end() - static_cast<std::ptrdiff_t>(max_count);
  }
  items.erase(items.begin(), first);
}

/// `vector` after it went back to zero by `rate` for some time.
Vector3 Bled(const Vector3& vector, double rate, double time_s) {
  const double length = Norm(vector);
  const double left = length - rate * std::max(0.0, time_s);
  return left <= 0.0 ? Vector3{} : (left / length) * vector;
}

void Shift(const SmoothOffset& offset, const PoseOptions& options, PoseEstimate& estimate) {
  const double time_s = 1e-9 * static_cast<double>(estimate.stamp_ns - offset.stamp_ns);
  const Vector3 turn = Bled(offset.turn_rad, options.bleed_radps, time_s);
  const Vector3 shift = Bled(offset.shift_m, options.bleed_mps, time_s);
  const RigidPose rotation = Exp({0.0, 0.0, 0.0, turn[0], turn[1], turn[2]});
  RigidPose& T = estimate.T_map_vehicle;
  const Vector3 before_m = T.translation_m;
  T.translation_m = offset.centre_m + Rotate(rotation, T.translation_m - offset.centre_m) + shift;
  T.rotation_wxyz = (rotation * RigidPose{{}, T.rotation_wxyz}).rotation_wxyz;
  const Vector3 moved_m = T.translation_m - before_m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      estimate.covariance[6 * i + j] += moved_m[i] * moved_m[j];
      estimate.covariance[6 * (3 + i) + 3 + j] += turn[i] * turn[j];
    }
  }
}

absl::StatusOr<PoseEstimate> Look(const PublishedTimeline& timeline, std::int64_t stamp_ns,
                                  const PoseOptions& options, bool is_smooth) {
  const PublishedTimeline::Found found = timeline.Find(stamp_ns);
  if (found.head.segment_count == 0) {
    return absl::FailedPreconditionError("no answer with a pose has come yet, or none any more");
  }
  if (stamp_ns > found.head.end_ns) {
    return absl::OutOfRangeError(
        absl::StrCat("stamp_ns is ", stamp_ns, ", ", (stamp_ns - found.head.end_ns) / 1'000'000,
                     " ms later than pose.max_ahead after the newest answer"));
  }
  if (!found.segment) {
    return absl::OutOfRangeError(
        absl::StrCat("stamp_ns is ", stamp_ns, "; what is kept begins at ", found.begin_ns));
  }
  PoseEstimate estimate = Evaluate(*found.segment, stamp_ns, options);
  if (is_smooth) Shift(found.head.offset, options, estimate);
  return estimate;
}

}  // namespace

PoseTracker::PoseTracker(const PoseOptions& options)
    : options_(options), learned_{.scale_sigma = options.velocity_scale_sigma} {}

absl::StatusOr<PoseEstimate> PoseTracker::PoseAt(std::int64_t stamp_ns) const {
  return Look(published_, stamp_ns, options_, false);
}

absl::StatusOr<PoseEstimate> PoseTracker::SmoothPoseAt(std::int64_t stamp_ns) const {
  return Look(published_, stamp_ns, options_, true);
}

void PoseTracker::AddAnswer(const v1::LocalizationResult& result) {
  const std::lock_guard lock(mutex_);
  StartOverIfSetBack(result.stamp_ns());
  if (result.has_learned_rig()) {
    const v1::LearnedRig& rig = result.learned_rig();
    const bool has_scale = rig.has_wheel_scale();
    learned_ = {
        .scale = has_scale ? rig.wheel_scale().value() : 1.0,
        .scale_sigma = has_scale ? rig.wheel_scale().sigma() : options_.velocity_scale_sigma,
        .knows_scale = has_scale,
        .yaw_rate_correction_radps = rig.yaw_rate_correction_radps().value(),
        .yaw_rate_sigma_radps = rig.has_yaw_rate_correction_radps()
                                    ? std::optional(rig.yaw_rate_correction_radps().sigma())
                                    : std::nullopt};
  }
  trusts_given_ = !IsFaulty(result.health().wheel_speed()) && !IsFaulty(result.health().yaw_rate());
  if (!HasPoseInMap(result)) {
    anchors_.clear();
    next_answer_jumps_ = true;
  } else {
    Anchor anchor = AnchorOf(result);
    anchor.jumped = next_answer_jumps_ || result.resets().count() != reset_count_;
    Insert(anchor, anchors_);
    next_answer_jumps_ = false;
  }
  reset_count_ = result.resets().count();
  Publish();
}

absl::Status PoseTracker::AddVelocity(std::int64_t stamp_ns, const v1::EgoVelocity& velocity) {
  const absl::StatusOr<GivenVelocity> given = VelocityOf(stamp_ns, velocity);
  if (!given.ok()) return given.status();
  const std::lock_guard lock(mutex_);
  // The newest one is always known, those before it often enough.
  const std::size_t count = given_.size();
  if (count >= 2 && stamp_ns > given_[count - 1].stamp_ns &&
      given_[count - 1].stamp_ns - given_[count - 2].stamp_ns < kMinVelocityInterval_ns) {
    given_.pop_back();
  }
  Insert(*given, given_);
  Publish();
  return absl::OkStatus();
}

void PoseTracker::BeginAnew() {
  const std::lock_guard lock(mutex_);
  next_answer_jumps_ = true;
}

void PoseTracker::StartOverIfSetBack(std::int64_t stamp_ns) {
  if (stamp_ns >= newest_ns_ - kClockSet_ns) return;
  anchors_.clear();
  given_.clear();
  next_answer_jumps_ = true;
  newest_ns_ = 0;
}

bool PoseTracker::UsesGivenVelocity() const {
  return trusts_given_ && !given_.empty() &&
         given_.back().stamp_ns >=
             anchors_.back().stamp_ns - Nanoseconds(options_.max_velocity_age);
}

std::vector<GivenVelocity> PoseTracker::CorrectedVelocities() const {
  std::vector<GivenVelocity> corrected = given_;
  std::int64_t previous_ns = 0;
  for (GivenVelocity& given : corrected) {
    for (std::size_t i = 0; i < 3; ++i) given.velocity[i] *= learned_.scale;
    given.velocity[5] += learned_.yaw_rate_correction_radps;
    const double interval_s = 1e-9 * static_cast<double>(given.stamp_ns - previous_ns);
    if (given.has_usual_variances) SetUsualVariances(std::min(interval_s, kMaxInterval_s), given);
    previous_ns = given.stamp_ns;
  }
  return corrected;
}

/// Once the server has learned what is constantly wrong, the rest is each reading's own.
void PoseTracker::SetUsualVariances(double interval_s, GivenVelocity& given) const {
  given.variances = UsualVariances(given.velocity, learned_.scale_sigma, options_);
  if (learned_.knows_scale) {
    given.variances[0] = std::pow(learned_.scale_sigma * given.velocity[0], 2);
    given.noise[0] = std::pow(options_.velocity_sigma_mps, 2) * interval_s;
  }
  if (learned_.yaw_rate_sigma_radps) {
    given.variances[5] = std::pow(*learned_.yaw_rate_sigma_radps, 2);
    given.noise[5] = std::pow(options_.turn_rate_sigma_radps, 2) * interval_s;
  }
}

void PoseTracker::Publish() {
  if (anchors_.empty()) {
    ForgetBefore(given_.empty() ? 0 : given_.back().stamp_ns - Nanoseconds(options_.kept),
                 kMaxVelocities, given_);
    return published_.Publish({}, {});
  }
  const std::int64_t oldest_ns = anchors_.back().stamp_ns - Nanoseconds(options_.kept);
  ForgetBefore(oldest_ns, kMaxAnchors, anchors_);
  ForgetBefore(oldest_ns, kMaxVelocities, given_);
  const bool uses_given = UsesGivenVelocity();
  newest_ns_ = anchors_.back().stamp_ns;
  if (uses_given) newest_ns_ = std::max(newest_ns_, given_.back().stamp_ns);
  const std::vector<Segment> segments = MakeTimeline(
      anchors_, uses_given ? CorrectedVelocities() : std::vector<GivenVelocity>(), options_);
  published_.Publish(segments,
                     {.end_ns = anchors_.back().stamp_ns + Nanoseconds(options_.max_ahead),
                      .offset = OffsetTo(segments)});
}

/// What leads from the new timeline to where the smooth poses are now.
SmoothOffset PoseTracker::OffsetTo(const std::vector<Segment>& segments) const {
  SmoothOffset offset{.stamp_ns = newest_ns_};
  const absl::StatusOr<PoseEstimate> before = SmoothPoseAt(newest_ns_);
  if (!before.ok()) return offset;
  const auto after =
      std::ranges::upper_bound(segments, newest_ns_, std::ranges::less(), &Segment::begin_ns);
  const RigidPose now = Evaluate(*std::prev(after), newest_ns_, options_).T_map_vehicle;
  const Vector3 shift_m = before->T_map_vehicle.translation_m - now.translation_m;
  if (Norm(shift_m) > options_.max_smoothed_m) return offset;
  const RigidPose turn = RigidPose{{}, before->T_map_vehicle.rotation_wxyz} *
                         Inverse(RigidPose{{}, now.rotation_wxyz});
  const Vector6 log = Log(turn);
  offset.centre_m = now.translation_m;
  offset.shift_m = shift_m;
  offset.turn_rad = {log[3], log[4], log[5]};
  return offset;
}

}  // namespace dcloc::client
