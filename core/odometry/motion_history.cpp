#include "core/odometry/motion_history.h"

#include <algorithm>
#include <iterator>

namespace dcloc {

void MotionHistory::Add(Stamp stamp, const Motion& since_last, const EgoVelocity& velocity) {
  const auto kept = std::ranges::find_if(
      entries_, [&](const Entry& entry) { return stamp - entry.stamp <= span_; });
  entries_.erase(entries_.begin(), kept);
  entries_.push_back({stamp, since_last, velocity});
}

std::optional<MotionHistory::Moment> MotionHistory::At(Stamp stamp) const {
  if (entries_.empty() || stamp > entries_.back().stamp) return std::nullopt;
  Moment moment{.to_newest = {}, .velocity = entries_.back().velocity};
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    moment.velocity = entry->velocity;
    if (entry->stamp <= stamp) return moment;
    const auto before = std::next(entry);
    if (before == entries_.rend()) return std::nullopt;
    if (before->stamp >= stamp) {
      moment.to_newest = Compose(entry->since_last, moment.to_newest);
      continue;
    }
    const double fraction = std::chrono::duration<double>(stamp - before->stamp) /
                            std::chrono::duration<double>(entry->stamp - before->stamp);
    moment.to_newest = Compose(Split(entry->since_last, fraction).second, moment.to_newest);
    return moment;
  }
  return std::nullopt;
}

std::optional<MotionHistory::Moment> MotionHistory::AtOrSoonAfter(Stamp stamp) const {
  if (entries_.empty() || stamp <= entries_.back().stamp) return At(stamp);
  const Entry& newest = entries_.back();
  const std::chrono::nanoseconds ahead = stamp - newest.stamp;
  if (ahead > span_) return std::nullopt;
  const EgoVelocity& velocity = newest.velocity;
  return Moment{.to_newest = Inverse(Integrate(velocity, velocity, ahead, options_)),
                .velocity = velocity};
}

}  // namespace dcloc
