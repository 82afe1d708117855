#include "core/submap/submap.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

// How points that were seen some time ago come into the newest scan's vehicle frame.
struct Carried {
  Eigen::Matrix3d R_newest_then;
  Eigen::Vector3d t_newest_then;
  Matrix6d drift;  ///< of T_newest_then on its right, turned into the newest frame's axes

  explicit Carried(const Motion& since_then) {
    const Pose3 T_newest_then = since_then.T_from_to.Inverse();
    R_newest_then = T_newest_then.Rotation();
    t_newest_then = T_newest_then.translation_m;
    Matrix6d turn = Matrix6d::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = R_newest_then;
    drift = InvertCovariance<3>(since_then.T_from_to, since_then.covariance);
    drift = turn * drift * turn.transpose();
  }

  Eigen::Vector3d Position(const RadarPoint& point) const {
    return R_newest_then * point.position_m + t_newest_then;
  }

  Eigen::Vector2d Slant(const RadarPoint& point) const {
    return R_newest_then.topLeftCorner<2, 2>() * point.slant_per_m;
  }

  // The covariance's part in x and y, or all of it.
  template <int Dim>
  Eigen::Matrix<double, Dim, Dim> Covariance(const RadarPoint& point, DriftCovariance with) const {
    const Eigen::Matrix<double, Dim, 3> R = R_newest_then.topRows<Dim>();
    Eigen::Matrix<double, Dim, Dim> own = R * point.covariance_m2 * R.transpose();
    if (with == DriftCovariance::kLeftOut) return own;
    // p = T Exp(xi) p_then: G = R [I, -[p_then]x] = [I, -[R p_then]x] diag(R, R).
    const Eigen::Matrix<double, Dim, 3> arm =
        -Skew(R_newest_then * point.position_m).topRows<Dim>();
    const Eigen::Matrix<double, Dim, Dim> cross = drift.topRightCorner<Dim, 3>() * arm.transpose();
    return own + drift.topLeftCorner<Dim, Dim>() + cross + cross.transpose() +
           arm * drift.bottomRightCorner<3, 3>() * arm.transpose();
  }
};

}  // namespace

SubmapWindow::KeptPoint::KeptPoint(const RadarPoint& point)
    : position_m(point.position_m.cast<float>()),
      rcs_dbsm(point.rcs_dbsm),
      slant_per_m(point.slant_per_m.cast<float>()) {
  std::size_t next = 0;
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) {
      covariance_m2[next++] = static_cast<float>(point.covariance_m2(row, column));
    }
  }
}

RadarPoint SubmapWindow::KeptPoint::Unpack() const {
  const auto& [xx, xy, xz, yy, yz, zz] = covariance_m2;
  Eigen::Matrix3f covariance;
  covariance << xx, xy, xz,  //
      xy, yy, yz,            //
      xz, yz, zz;
  return {.position_m = position_m.cast<double>(),
          .covariance_m2 = covariance.cast<double>(),
          .rcs_dbsm = rcs_dbsm,
          .slant_per_m = slant_per_m.cast<double>()};
}

std::span<const OptionField<SubmapOptions>> FieldsOf(const SubmapOptions& /*options*/) {
  using O = SubmapOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_age_ms", &O::max_age, 1, 60'000},
      {"max_scan_points", &O::max_scan_points, 10, 100'000},
  };
  return kFields;
}

absl::Status Validate(const SubmapOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

void SubmapWindow::Push(Stamp stamp, int radar_index, const std::vector<RadarPoint>& points,
                        const Motion& motion) {
  const auto is_old = [&](const Entry& entry) { return stamp - entry.stamp > options_.max_age; };
  entries_.erase(entries_.begin(), std::ranges::find_if_not(entries_, is_old));
  // The new scan takes the oldest one's memory.
  const auto room = MakeRoom(radar_index);
  std::rotate(room, std::next(room), entries_.end());
  Entry& newest = entries_.back();
  newest.stamp = stamp;
  newest.radar_index = radar_index;
  newest.motion = motion;
  Fill(newest, points);
}

bool SubmapWindow::Insert(Stamp stamp, int radar_index, const std::vector<RadarPoint>& points) {
  const auto is_later = [&](const Entry& entry) { return entry.stamp > stamp; };
  if (entries_.empty() || is_later(entries_.front())) return false;
  const auto next = std::ranges::find_if(entries_, is_later);
  Entry late{.stamp = stamp, .radar_index = radar_index, .points = {}, .motion = {}};
  Fill(late, points);
  if (next != entries_.end()) {  // it is reached by what is left of its motion
    const Stamp before = std::prev(next)->stamp;
    const double share = std::chrono::duration<double>(stamp - before) /
                         std::chrono::duration<double>(next->stamp - before);
    std::tie(late.motion, next->motion) = Split(next->motion, share);
  }
  const auto inserted = entries_.insert(next, std::move(late));
  const auto of_same_radar = [&](const Entry& entry) { return entry.radar_index == radar_index; };
  if (std::ranges::count_if(entries_, of_same_radar) <= scans_per_radar_) return true;
  const auto dropped = MakeRoom(radar_index);
  const bool is_kept = dropped != inserted;
  entries_.erase(dropped);
  return is_kept;
}

// An entry to be written anew: the oldest one of a radar that has enough of them, of which the
// successor takes over the motion; or one more.
std::vector<SubmapWindow::Entry>::iterator SubmapWindow::MakeRoom(int radar_index) {
  const auto of_same_radar = [&](const Entry& entry) { return entry.radar_index == radar_index; };
  if (std::ranges::count_if(entries_, of_same_radar) < scans_per_radar_) {
    entries_.emplace_back();
    return std::prev(entries_.end());
  }
  const auto oldest = std::ranges::find_if(entries_, of_same_radar);
  if (const auto successor = std::next(oldest); successor != entries_.end()) {
    successor->motion = Compose(oldest->motion, successor->motion);
  }
  return oldest;
}

void SubmapWindow::Fill(Entry& entry, const std::vector<RadarPoint>& points) const {
  const std::size_t count =
      std::min(points.size(), static_cast<std::size_t>(options_.max_scan_points));
  entry.points.clear();
  // Room for some more, as the next scan may be a little larger.
  if (count > entry.points.capacity()) entry.points.reserve(count + count / 8);
  for (std::size_t i = 0; i < count; ++i) {
    entry.points.emplace_back(points[i * points.size() / count]);
  }
}

template <typename Visit>
void SubmapWindow::ForEachScan(const Visit& visit) const {
  Motion since_then;  // from the entry at hand to the newest (METHOD eq 7-8)
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    visit(*entry, since_then.T_from_to.Inverse(), Carried(since_then));
    since_then = Compose(entry->motion, since_then);
  }
}

Submap SubmapWindow::Join(DriftCovariance drift) const {
  Submap submap{.points = {}, .scan_count = scan_count(), .span = span()};
  submap.points.reserve(point_count());
  ForEachScan([&](const Entry& entry, const Pose3&, const Carried& carried) {
    for (const KeptPoint& kept : entry.points) {
      const RadarPoint point = kept.Unpack();
      submap.points.push_back({.position_m = carried.Position(point),
                               .covariance_m2 = carried.Covariance<3>(point, drift),
                               .rcs_dbsm = point.rcs_dbsm,
                               .slant_per_m = carried.Slant(point)});
    }
  });
  return submap;
}

template <int Dim>
void SubmapWindow::Join(DriftCovariance drift, std::size_t max_count,
                        LiveSubmap<Dim>& submap) const {
  const std::size_t stride = std::max<std::size_t>(1, (point_count() + max_count - 1) / max_count);
  submap.points.clear();
  submap.parts.clear();
  std::size_t number = 0;
  ForEachScan([&](const Entry& entry, const Pose3& T_newest_then, const Carried& carried) {
    const std::size_t begin = submap.points.size();
    for (const KeptPoint& kept : entry.points) {
      if (number++ % stride != 0) continue;
      const RadarPoint point = kept.Unpack();
      submap.points.push_back({.mean_m = carried.Position(point).head<Dim>(),
                               .covariance_m2 = carried.Covariance<Dim>(point, drift)});
      if constexpr (Dim == 2) submap.points.back().slant_per_m = carried.Slant(point);
    }
    submap.parts.push_back({entry.radar_index, T_newest_then, begin, submap.points.size()});
  });
}

void SubmapWindow::DropPoints(int radar_index) {
  for (Entry& entry : entries_) {
    if (entry.radar_index == radar_index) entry.points.clear();
  }
}

std::size_t SubmapWindow::point_count() const {
  std::size_t count = 0;
  for (const Entry& entry : entries_) count += entry.points.size();
  return count;
}

std::chrono::nanoseconds SubmapWindow::span() const {
  if (entries_.empty()) return std::chrono::nanoseconds(0);
  return entries_.back().stamp - entries_.front().stamp;
}

template void SubmapWindow::Join<2>(DriftCovariance, std::size_t, LiveSubmap<2>&) const;
template void SubmapWindow::Join<3>(DriftCovariance, std::size_t, LiveSubmap<3>&) const;

}  // namespace dcloc
