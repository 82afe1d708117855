#include "client/sdk/pose/timeline.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace dcloc::client {
namespace {

/// Of a vehicle of whose motion nothing is known.
constexpr Vector6 kUnknownVariances = {400.0, 4.0, 1.0, 0.01, 0.01, 0.25};
/// Velocities are told from answers that lie so far apart, where there are any.
constexpr std::int64_t kBaseline_ns = 300'000'000;
/// So far ahead of the axle that does not slip sideways the vehicle frame may lie: a turn that
/// begins moves it sideways.
constexpr double kAheadOfAxle_m = 3.0;

double Seconds(std::int64_t duration_ns) { return 1e-9 * static_cast<double>(duration_ns); }

/// What a change of the velocity adds in the plane, which `factor` takes to the unit: seconds for a
/// velocity, seconds squared for a way.
Vector6 AccelerationVariances(double factor, const PoseOptions& options) {
  const double turn = options.turn_acceleration_sigma_radps2 * factor;
  return {std::pow(options.acceleration_sigma_mps2 * factor, 2),
          std::pow(kAheadOfAxle_m * turn, 2),
          0.0,
          0.0,
          0.0,
          turn * turn};
}

/// The velocity at any stamp: between those given on a straight line, beyond them the nearest.
GivenVelocity VelocityAt(const std::vector<GivenVelocity>& given, std::int64_t stamp_ns) {
  const auto after =
      std::ranges::lower_bound(given, stamp_ns, std::ranges::less(), &GivenVelocity::stamp_ns);
  if (after == given.begin()) return given.front();
  if (after == given.end()) return given.back();
  const GivenVelocity& a = *std::prev(after);
  const GivenVelocity& b = *after;
  const double share = Seconds(stamp_ns - a.stamp_ns) / Seconds(b.stamp_ns - a.stamp_ns);
  return {stamp_ns, a.velocity + share * (b.velocity - a.velocity), a.variances, a.noise};
}

/// What the answers say of the velocity at the last one, from those since the last jump.
GivenVelocity VelocityOfAnswers(const std::vector<Anchor>& anchors, const PoseOptions& options) {
  const Anchor& last = anchors.back();
  const Anchor* first = &last;
  for (auto i = anchors.rbegin(); i != anchors.rend(); ++i) {
    first = &*i;
    if (i->jumped || last.stamp_ns - i->stamp_ns >= kBaseline_ns) break;
  }
  if (first == &last) return {last.stamp_ns, {}, kUnknownVariances};
  const double duration_s = Seconds(last.stamp_ns - first->stamp_ns);
  const Vector6 way = Log(Inverse(first->T_map_vehicle) * last.T_map_vehicle);
  Vector6 variances;
  for (std::size_t i = 0; i < variances.size(); ++i) {
    // Along the map's axes, which is near enough: the larger of the two horizontal ones.
    const std::size_t j = i < 2 ? 1 - i : i;
    const double variance = std::max(last.covariance[7 * i], last.covariance[7 * j]) +
                            std::max(first->covariance[7 * i], first->covariance[7 * j]);
    variances[i] = variance / (duration_s * duration_s);
  }
  // It is that of the time's middle, and may have changed since.
  const double half_s = 0.5 * duration_s;
  variances = variances + AccelerationVariances(half_s, options);
  return {last.stamp_ns, (1.0 / duration_s) * way, variances};
}

/// Makes the segments from one anchor to the next, or to the end of time.
class Builder {
 public:
  Builder(const std::vector<GivenVelocity>& given, const PoseOptions& options)
      : given_(given), options_(options) {}

  void AddOpen(const Anchor& anchor) {
    Begin(anchor);
    for (const GivenVelocity& next : given_) {
      if (next.stamp_ns > anchor.stamp_ns) Split(next.stamp_ns);
    }
  }

  /// To an answer that follows it.
  void AddClosed(const Anchor& anchor, const Anchor& next) {
    const std::size_t first = segments_.size();
    Begin(anchor);
    for (const GivenVelocity& velocity : given_) {
      if (velocity.stamp_ns > anchor.stamp_ns && velocity.stamp_ns < next.stamp_ns) {
        Split(velocity.stamp_ns);
      }
    }
    const RigidPose reached = Evaluate(segments_.back(), next.stamp_ns, options_).T_map_vehicle;
    const Vector6 correction = (1.0 / Seconds(next.stamp_ns - anchor.stamp_ns)) *
                               Log(Inverse(reached) * next.T_map_vehicle);
    for (std::size_t i = first; i < segments_.size(); ++i) {
      const bool is_last = i + 1 == segments_.size();
      const std::int64_t end_ns = is_last ? next.stamp_ns : segments_[i + 1].begin_ns;
      SetCorrection(correction, next.stamp_ns, segments_[i]);
      SetCovarianceBetween(anchor, next, end_ns, segments_[i]);
    }
  }

  /// Up to an answer that does not follow.
  void AddBroken(const Anchor& anchor, const Anchor& next) {
    AddOpen(anchor);
    std::erase_if(segments_, [&](const Segment& segment) {
      return segment.answer_ns == anchor.stamp_ns && segment.begin_ns >= next.stamp_ns;
    });
  }

  void SetVelocityOfAnswers(const GivenVelocity& velocity) {
    segments_.back().velocity = velocity.velocity;
    segments_.back().variances = velocity.variances;
  }

  std::vector<Segment> Take() { return std::move(segments_); }

 private:
  void Begin(const Anchor& anchor) {
    segments_.push_back({.begin_ns = anchor.stamp_ns,
                         .answer_ns = anchor.stamp_ns,
                         .known_ns = anchor.stamp_ns,
                         .state = anchor.state,
                         .begin = anchor.T_map_vehicle,
                         .velocity = {},
                         .acceleration = {},
                         .correction = {},
                         .origin_ns = anchor.stamp_ns,
                         .origin_m = anchor.T_map_vehicle.translation_m,
                         .covariance = anchor.covariance,
                         .variances = kUnknownVariances,
                         .noise = {}});
    SetMotion(segments_.back());
  }

  void Split(std::int64_t stamp_ns) {
    Segment segment = segments_.back();
    segment.begin = Evaluate(segment, stamp_ns, options_).T_map_vehicle;
    segment.begin_ns = stamp_ns;
    SetMotion(segment);
    segments_.push_back(segment);
  }

  /// From the velocities at its begin and at the next one that was given.
  void SetMotion(Segment& segment) const {
    if (given_.empty()) return;
    const GivenVelocity begin = VelocityAt(given_, segment.begin_ns);
    segment.velocity = begin.velocity;
    segment.variances = begin.variances;
    segment.noise = begin.noise;
    segment.acceleration = {};
    segment.known_ns = std::max(segment.begin_ns, given_.back().stamp_ns);
    const auto next = std::ranges::upper_bound(given_, segment.begin_ns, std::ranges::less(),
                                               &GivenVelocity::stamp_ns);
    if (next == given_.end() || next == given_.begin()) return;
    segment.acceleration =
        (1.0 / Seconds(next->stamp_ns - segment.begin_ns)) * (next->velocity - begin.velocity);
  }

  /// Makes a segment lead to the next answer.
  void SetCorrection(const Vector6& correction, std::int64_t next_ns, Segment& segment) const {
    segment.known_ns = next_ns;
    if (given_.empty()) {
      segment.velocity = correction;  // that is all the motion
    } else {
      segment.correction = correction;
    }
  }

  /// As certain as both answers, and less in between.
  void SetCovarianceBetween(const Anchor& anchor, const Anchor& next, std::int64_t end_ns,
                            Segment& segment) const {
    const double before_s =
        0.5 * (Seconds(segment.begin_ns - anchor.stamp_ns) + Seconds(end_ns - anchor.stamp_ns));
    const double after_s = Seconds(next.stamp_ns - anchor.stamp_ns) - before_s;
    const double share = before_s / (before_s + after_s);
    for (std::size_t i = 0; i < segment.covariance.size(); ++i) {
      segment.covariance[i] = (1.0 - share) * anchor.covariance[i] + share * next.covariance[i];
    }
    const double nearest_s = std::min(before_s, after_s);
    Vector6 added = std::pow(nearest_s, 2) * segment.variances + nearest_s * segment.noise;
    if (given_.empty()) {  // the velocity may have changed meanwhile
      added = AccelerationVariances(0.5 * before_s * after_s, options_);
    }
    AddVariances(segment.begin, added, segment.covariance);
    segment.variances = {};
    segment.noise = {};
    segment.origin_m = segment.begin.translation_m;
    segment.origin_ns = segment.begin_ns;
  }

  const std::vector<GivenVelocity>& given_;
  const PoseOptions& options_;
  std::vector<Segment> segments_;
};

}  // namespace

std::vector<Segment> MakeTimeline(const std::vector<Anchor>& anchors,
                                  const std::vector<GivenVelocity>& given,
                                  const PoseOptions& options) {
  if (anchors.empty()) return {};
  Builder builder(given, options);
  for (std::size_t i = 0; i + 1 < anchors.size(); ++i) {
    if (anchors[i + 1].jumped) {
      builder.AddBroken(anchors[i], anchors[i + 1]);
    } else {
      builder.AddClosed(anchors[i], anchors[i + 1]);
    }
  }
  builder.AddOpen(anchors.back());
  if (given.empty()) builder.SetVelocityOfAnswers(VelocityOfAnswers(anchors, options));
  return builder.Take();
}

PoseEstimate Evaluate(const Segment& segment, std::int64_t stamp_ns, const PoseOptions& options) {
  const double time_s = Seconds(stamp_ns - segment.begin_ns);
  const Vector6 mean = segment.velocity + 0.5 * time_s * segment.acceleration;
  PoseEstimate estimate{
      .stamp_ns = stamp_ns,
      .T_map_vehicle = segment.begin * Exp(time_s * mean) *
                       Exp(Seconds(stamp_ns - segment.answer_ns) * segment.correction),
      .covariance = {},
      .velocity = segment.velocity + time_s * segment.acceleration + segment.correction,
      .answer_stamp_ns = segment.answer_ns,
      .state = static_cast<v1::LocalizationState>(segment.state)};
  const RigidPose& T = estimate.T_map_vehicle;
  const Vector3 way_m = T.translation_m - segment.origin_m;
  estimate.covariance = MoveCovariance(segment.covariance, way_m);
  const double since_s = Seconds(stamp_ns - segment.origin_ns);
  const double held_s = std::max(0.0, Seconds(stamp_ns - segment.known_ns));
  const double half_s2 = 0.5 * held_s * held_s;
  Vector6 added = since_s * since_s * segment.variances + since_s * segment.noise;
  added[0] += std::pow(options.acceleration_sigma_mps2 * half_s2, 2);
  added[5] += std::pow(options.turn_acceleration_sigma_radps2 * half_s2, 2);
  // A turn that is not known bends the path: its end by half of it.
  added[1] += std::pow(0.5 * Norm(way_m), 2) * added[5];
  AddVariances(T, added, estimate.covariance);
  return estimate;
}

}  // namespace dcloc::client
