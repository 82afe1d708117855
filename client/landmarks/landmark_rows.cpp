#include "client/landmarks/landmark_rows.h"

#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/map/keyframe_index.h"
#include "core/map/map_content.h"
#include "core/map/map_file.h"
#include "core/map/point_grid.h"

namespace dcloc {
namespace {

constexpr double kMoved_m = 0.01;

Pose3 PoseInMap(const EditableMap& map, std::size_t keyframe) {
  Pose3 pose = PoseOf(map.keyframes[keyframe].record);
  pose.translation_m += map.Origin_m();
  return pose;
}

// Bit by bit: what is not touched keeps its bits.
bool IsSame(const MapPoint& a, const MapPoint& b) {
  using Bytes = std::array<std::byte, sizeof(MapPoint)>;
  return std::bit_cast<Bytes>(a) == std::bit_cast<Bytes>(b);
}

Eigen::Matrix3d CovarianceOf(const MapPoint& p) {
  Eigen::Matrix3d covariance_m2;
  covariance_m2 << p.xx_m2, p.xy_m2, p.xz_m2, p.xy_m2, p.yy_m2, p.yz_m2, p.xz_m2, p.yz_m2, p.zz_m2;
  return covariance_m2;
}

MapPoint Placed(MapPoint point, const Eigen::Vector3d& p_keyframe,
                const Eigen::Matrix3d& covariance_m2) {
  const Eigen::Vector3f p = p_keyframe.cast<float>();
  const Eigen::Matrix3f c = covariance_m2.cast<float>();
  point.x_m = p.x();
  point.y_m = p.y();
  point.z_m = p.z();
  point.xx_m2 = c(0, 0);
  point.xy_m2 = c(0, 1);
  point.xz_m2 = c(0, 2);
  point.yy_m2 = c(1, 1);
  point.yz_m2 = c(1, 2);
  point.zz_m2 = c(2, 2);
  return point;
}

// Keyframes of a map lie no further away.
constexpr double kMaxLandmarkCoordinate_m = kMaxOrigin_m + kMaxLocal_m;

// Puts rows into a copy of the base, one at a time.
class Mender {
 public:
  explicit Mender(const EditableMap& base)
      : base_(base), anchor_(base.Anchor()), mended_(base), grid_(kMaxKeyframeDistance_m) {
    for (std::size_t i = 0; i < base.keyframes.size(); ++i) {
      mended_.keyframes[i].points.clear();
      grid_.Insert(PoseInMap(base, i).translation_m.head<2>());
      taken_.emplace_back(base.keyframes[i].points.size(), false);
    }
  }

  absl::Status Add(const LandmarkRow& row) {
    if (absl::Status status = CheckPlace(row); !status.ok()) return status;
    if (row.keyframe && *row.keyframe >= base_.keyframes.size()) {
      return Error(row, absl::StrFormat("keyframe is %d; the base map has %d", *row.keyframe,
                                        base_.keyframes.size()));
    }
    if (row.keyframe) {
      const Eigen::Vector3d shown = PoseInMap(base_, *row.keyframe) * PositionOf(row.point);
      LandmarkRow in_space = row;
      if (!row.has_height) in_space.p_map = AtHeightOf(shown, row.p_map);
      if (absl::Status status = CheckPlace(in_space); !status.ok()) return status;
      return (in_space.p_map - shown).norm() < kMoved_m ? Keep(row) : Place(in_space);
    }
    return Place(row);
  }

  EditableMap Finish(LandmarkEdits& counts) && {
    counts_.removed = base_.PointCount() - counts_.same - counts_.moved - counts_.edited;
    counts = counts_;
    return std::move(mended_);
  }

 private:
  static absl::Status Error(const LandmarkRow& row, absl::string_view what) {
    return absl::InvalidArgumentError(absl::StrCat(row.name, ": ", what));
  }

  static absl::Status CheckPlace(const LandmarkRow& row) {
    constexpr std::array kNames = {"x", "y", "z"};
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      const double value = row.p_map(static_cast<Eigen::Index>(i));
      if (std::abs(value) <= kMaxLandmarkCoordinate_m) continue;  // NaN is not
      return Error(
          row, absl::StrFormat("%s is %g m in the map; it must lie in [%g, %g]", kNames[i], value,
                               -kMaxLandmarkCoordinate_m, kMaxLandmarkCoordinate_m));
    }
    return absl::OkStatus();
  }

  // `p_map` as high as `like`: over the ellipsoid, so that longitude and latitude stay, whose
  // verticals are not the map's z.
  Eigen::Vector3d AtHeightOf(const Eigen::Vector3d& like, const Eigen::Vector3d& p_map) const {
    if (!anchor_) return {p_map.x(), p_map.y(), like.z()};
    GeodeticPosition place = GeodeticFromMap(*anchor_, p_map);
    place.height_m = GeodeticFromMap(*anchor_, like).height_m;
    return MapFromGeodetic(*anchor_, place);
  }

  absl::Status Put(const LandmarkRow& row, std::size_t keyframe, const MapPoint& point) {
    if (absl::Status status = CheckPoints({&point, 1}); !status.ok()) {
      return Error(row, status.message().substr(status.message().find(": ") + 2));
    }
    mended_.keyframes[keyframe].points.push_back(point);
    return absl::OkStatus();
  }

  // Takes the base's landmark that `is_wanted`, once, so that a copied row counts as added.
  template <typename Wanted>
  bool Take(std::size_t keyframe, const Wanted& is_wanted) {
    const std::vector<MapPoint>& points = base_.keyframes[keyframe].points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (taken_[keyframe][i] || !is_wanted(points[i])) continue;
      taken_[keyframe][i] = true;
      return true;
    }
    return false;
  }

  absl::Status Keep(const LandmarkRow& row) {
    const auto same = [&](const MapPoint& point) { return IsSame(point, row.point); };
    const auto same_place = [&](const MapPoint& point) {
      return PositionOf(point) == PositionOf(row.point);
    };
    ++(Take(*row.keyframe, same)         ? counts_.same
       : Take(*row.keyframe, same_place) ? counts_.edited
                                         : counts_.added);
    return Put(row, *row.keyframe, row.point);
  }

  absl::Status Place(const LandmarkRow& row) {
    const std::optional<std::size_t> keyframe = KeyframeFor(row);
    if (!keyframe) {
      return Error(row, absl::StrFormat("it lies at (%.1f, %.1f) m, more than %g m from every "
                                        "keyframe of the base map",
                                        row.p_map.x(), row.p_map.y(), kMaxKeyframeDistance_m));
    }
    const auto same_place = [&](const MapPoint& point) {
      return PositionOf(point) == PositionOf(row.point);
    };
    const bool is_of_base = row.keyframe && Take(*row.keyframe, same_place);
    ++(is_of_base ? counts_.moved : counts_.added);
    const Pose3 T_map_keyframe = PoseInMap(base_, *keyframe);
    const Pose3 T_map_old = row.keyframe ? PoseInMap(base_, *row.keyframe) : Pose3();
    const Eigen::Matrix3d turn = T_map_keyframe.Rotation().transpose() * T_map_old.Rotation();
    const Eigen::Matrix3d covariance_m2 = CovarianceOf(row.point);
    const bool is_turned = row.keyframe != keyframe;
    return Put(row, *keyframe,
               Placed(row.point, T_map_keyframe.Inverse() * row.p_map,
                      is_turned ? turn * covariance_m2 * turn.transpose() : covariance_m2));
  }

  std::optional<std::size_t> KeyframeFor(const LandmarkRow& row) const {
    const auto distance_m = [&](std::size_t i) {
      return (PoseInMap(base_, i).translation_m - row.p_map).head<2>().norm();
    };
    if (row.keyframe && distance_m(*row.keyframe) <= kMaxKeyframeDistance_m) return *row.keyframe;
    std::optional<std::size_t> nearest;
    grid_.ForEachNear(row.p_map.head<2>(), Eigen::Vector2d::Constant(kMaxKeyframeDistance_m),
                      [&](std::uint32_t i) {
                        if (distance_m(i) > kMaxKeyframeDistance_m) return;
                        if (!nearest || distance_m(i) < distance_m(*nearest)) nearest = i;
                      });
    return nearest;
  }

  const EditableMap& base_;
  const std::optional<GeodeticAnchor> anchor_;
  EditableMap mended_;
  PointGrid grid_;
  std::vector<std::vector<bool>> taken_;  ///< of the base's landmarks, by keyframe
  LandmarkEdits counts_;
};

}  // namespace

std::vector<LandmarkRow> RowsOf(const EditableMap& map) {
  std::vector<LandmarkRow> rows;
  rows.reserve(map.PointCount());
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const Pose3 T_map_keyframe = PoseInMap(map, i);
    for (const MapPoint& point : map.keyframes[i].points) {
      rows.push_back({.p_map = T_map_keyframe * PositionOf(point),
                      .keyframe = static_cast<std::uint32_t>(i),
                      .point = point,
                      .name = {}});
    }
  }
  return rows;
}

absl::StatusOr<EditableMap> ReplaceLandmarks(const EditableMap& base,
                                             const std::vector<LandmarkRow>& rows,
                                             LandmarkEdits& counts) {
  if (rows.empty()) return absl::FailedPreconditionError("the file has no landmark");
  Mender mender(base);
  for (const LandmarkRow& row : rows) {
    if (absl::Status status = mender.Add(row); !status.ok()) return status;
  }
  return std::move(mender).Finish(counts);
}

}  // namespace dcloc
