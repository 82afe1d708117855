#include "client/sdk/prior.h"

#include <algorithm>
#include <cmath>

namespace dcloc::client {
namespace {

constexpr double kSecondsPerNanosecond = 1e-9;

// Of a vehicle that is lost too: its covariance says how far that holds.
bool HasPose(const v1::LocalizationResult& result) {
  return result.pose().covariance_size() == 36 &&
         (result.state() == v1::LOCALIZATION_STATE_TRACKING ||
          result.state() == v1::LOCALIZATION_STATE_DEAD_RECKONING ||
          result.state() == v1::LOCALIZATION_STATE_LOST);
}

double Speed(const v1::LocalizationResult& from, const v1::LocalizationResult& to) {
  const double duration_s =
      static_cast<double>(to.stamp_ns() - from.stamp_ns()) * kSecondsPerNanosecond;
  if (duration_s <= 0.0) return 0.0;
  const v1::Vector3& a = from.pose().pose().translation_m();
  const v1::Vector3& b = to.pose().pose().translation_m();
  return std::hypot(b.x() - a.x(), b.y() - a.y()) / duration_s;
}

}  // namespace

void Prior::Note(const v1::LocalizationResult& result) {
  noted_ = true;
  if (!HasPose(result)) {
    last_.reset();
    return;
  }
  if (last_ && result.stamp_ns() > last_->stamp_ns()) speed_mps_ = Speed(*last_, result);
  last_ = result;
}

void Prior::Apply(std::int64_t stamp_ns, v1::OpenSession* open) const {
  if (!noted_) return;
  open->clear_initialization();
  if (!last_) return;
  v1::PoseWithCovariance* pose = open->mutable_initial_pose();
  *pose = last_->pose();
  const double gap_s =
      static_cast<double>(std::max<std::int64_t>(0, stamp_ns - last_->stamp_ns())) *
      kSecondsPerNanosecond;
  const double way_m = speed_mps_ * gap_s;
  for (const int horizontal : {0, 7}) {
    pose->set_covariance(horizontal, pose->covariance(horizontal) + way_m * way_m);
  }
}

}  // namespace dcloc::client
