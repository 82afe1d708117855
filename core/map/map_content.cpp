#include "core/map/map_content.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>

#include "absl/strings/str_format.h"
#include "core/map/data_loss.h"
#include "core/map/keyframe_accuracy.h"
#include "core/map/keyframe_index.h"

namespace dcloc {
namespace {

// Written so that NaN fails.
bool WithinBound(std::span<const double> values, double bound) {
  for (const double value : values) {
    if (!(std::abs(value) <= bound)) return false;
  }
  return true;
}

absl::Status CheckInfo(const InfoRecord& info) {
  constexpr std::uint32_t kFlags =
      kHasElevationFlag | kHasAnchorFlag | kHasHeightsFlag | kHasKnownStampsFlag;
  constexpr std::uint32_t kDelay = 0xFFFFU << kStampDelayShift;
  if ((info.flags & ~kFlags & ~kDelay) != 0) {
    return DataLoss("info: flags are %x; only bits 0 to 3 and the upper half are known",
                    info.flags);
  }
  const std::optional<double> delay_s = StampDelayOf(info);
  if (!delay_s ? (info.flags & kDelay) != 0 : std::abs(*delay_s) > kMaxStampDelay_s) {
    return DataLoss("info: flags are %x; the upper half must be a delay within %g s, with bit 3",
                    info.flags, kMaxStampDelay_s);
  }
  if ((info.flags & kHasElevationFlag) != 0 && (info.flags & kHasHeightsFlag) != 0) {
    return DataLoss("info: flags are %x; measured points (bit 0) have no heights (bit 2)",
                    info.flags);
  }
  if (!WithinBound(info.local_origin_m, kMaxOrigin_m)) {
    return DataLoss("info: local_origin_m is beyond %g", kMaxOrigin_m);
  }
  if (!(info.length_m >= 0.0 && info.length_m <= 1e9)) {
    return DataLoss("info: length_m is %g; it must lie in [0, 1e9]", info.length_m);
  }
  if (!(info.index_cell_m >= 1.0 && info.index_cell_m <= 1e4)) {
    return DataLoss("info: index_cell_m is %g; it must lie in [1, 1e4]", info.index_cell_m);
  }
  const std::optional<GeodeticAnchor> anchor = AnchorOf(info);
  const absl::Status status = anchor ? Validate(*anchor) : absl::OkStatus();
  return status.ok() ? status : DataLoss("info: anchor: %s", status.message());
}

absl::Status CheckText(const MapFileView& view) {
  if (!IsMapText(view.name, kMaxMapName_bytes)) {
    return DataLoss("text: the name has %d bytes; it must be UTF-8 of at most %d", view.name.size(),
                    kMaxMapName_bytes);
  }
  if (!IsMapText(view.description, kMaxMapDescription_bytes)) {
    return DataLoss("text: the description has %d bytes; it must be UTF-8 of at most %d",
                    view.description.size(), kMaxMapDescription_bytes);
  }
  return absl::OkStatus();
}

absl::Status CheckKeyframe(const KeyframeRecord& keyframe, std::uint64_t first_point) {
  if (keyframe.first_point != first_point) {
    return DataLoss("first_point is %d; it must be %d", keyframe.first_point, first_point);
  }
  if (!IsAccuracyWord(keyframe.accuracy)) {
    return DataLoss("its accuracy is 0x%08x, which means nothing", keyframe.accuracy);
  }
  if (!WithinBound(keyframe.translation_local_m, kMaxLocal_m)) {
    return DataLoss("its position is beyond %g m of the local origin", kMaxLocal_m);
  }
  double squared_norm = 0.0;
  for (const double q : keyframe.rotation_wxyz) squared_norm += q * q;
  if (std::abs(squared_norm - 1.0) <= 1e-6) return absl::OkStatus();
  return DataLoss("its rotation has the squared norm %g; it must be 1", squared_norm);
}

absl::Status CheckKeyframes(const MapFileView& view) {
  std::uint64_t point_count = 0;
  for (std::size_t i = 0; i < view.keyframes.size(); ++i) {
    const absl::Status status = CheckKeyframe(view.keyframes[i], point_count);
    if (!status.ok()) return DataLoss("keyframe %d: %s", i, status.message());
    point_count += view.keyframes[i].point_count;
  }
  if (point_count == view.points.size()) return absl::OkStatus();
  return DataLoss("the keyframes hold %d points; the section points has %d", point_count,
                  view.points.size());
}

bool IsFinite(const MapPoint& point) {
  for (const float value : {point.x_m, point.y_m, point.z_m, point.xx_m2, point.xy_m2, point.xz_m2,
                            point.yy_m2, point.yz_m2, point.zz_m2, point.rcs_dbsm}) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

bool IsPositiveSemidefinite(const MapPoint& point) {
  Eigen::Matrix3d covariance;
  covariance << point.xx_m2, point.xy_m2, point.xz_m2, point.xy_m2, point.yy_m2, point.yz_m2,
      point.xz_m2, point.yz_m2, point.zz_m2;
  // What rounding to float may have taken away, and no more.
  const double slack_m2 = 1e-6 * covariance.cwiseAbs().maxCoeff() + 1e-12;
  const Eigen::LLT<Eigen::Matrix3d> llt(covariance + slack_m2 * Eigen::Matrix3d::Identity());
  return llt.info() == Eigen::Success;
}

// Length of the well-formed sequence at the start of `text` (Unicode 15, table 3-7), 0 if none.
std::size_t Utf8SequenceSize(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const auto within = [](unsigned value, unsigned low, unsigned high) {
    return low <= value && value <= high;
  };
  const unsigned lead = byte(0);
  if (within(lead, 0x01, 0x7F)) return 1;
  const auto tail = [&](std::size_t i) { return within(byte(i), 0x80, 0xBF); };
  if (within(lead, 0xC2, 0xDF)) return tail(1) ? 2 : 0;
  const unsigned low = lead == 0xE0 ? 0xA0 : lead == 0xF0 ? 0x90 : 0x80;
  const unsigned high = lead == 0xED ? 0x9F : lead == 0xF4 ? 0x8F : 0xBF;
  if (!within(byte(1), low, high) || !tail(2)) return 0;
  if (within(lead, 0xE0, 0xEF)) return 3;
  return within(lead, 0xF0, 0xF4) && tail(3) ? 4 : 0;
}

}  // namespace

absl::Status CheckContent(const MapFileView& view) {
  absl::Status status = CheckInfo(view.info);
  if (status.ok()) status = CheckText(view);
  if (status.ok()) status = CheckKeyframes(view);
  if (status.ok()) status = CheckIndex(view.index, view.keyframes, view.info.index_cell_m);
  return status;
}

absl::Status CheckPoints(std::span<const MapPoint> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!IsFinite(points[i])) return DataLoss("point %d: a value is not finite", i);
    if (!IsPositiveSemidefinite(points[i])) {
      return DataLoss("point %d: its covariance is not positive semidefinite", i);
    }
  }
  return absl::OkStatus();
}

bool IsMapText(std::string_view text, std::size_t max_bytes) {
  if (text.size() > max_bytes) return false;
  while (!text.empty()) {
    const std::size_t size = Utf8SequenceSize(text);
    if (size == 0) return false;
    text.remove_prefix(size);
  }
  return true;
}

std::optional<double> StampDelayOf(const InfoRecord& info) {
  if ((info.flags & kHasKnownStampsFlag) == 0) return std::nullopt;
  return 1e-3 * static_cast<std::int16_t>(info.flags >> kStampDelayShift);
}

void SetStampDelay(std::optional<double> stamp_delay_s, InfoRecord& info) {
  info.flags &= (1U << kStampDelayShift) - 1U;
  info.flags &= ~kHasKnownStampsFlag;
  if (!stamp_delay_s) return;
  const auto delay_ms = static_cast<std::uint16_t>(std::lround(1e3 * *stamp_delay_s));
  info.flags |= kHasKnownStampsFlag | static_cast<std::uint32_t>(delay_ms) << kStampDelayShift;
}

void SetAnchor(const std::optional<GeodeticAnchor>& anchor, InfoRecord& info) {
  const GeodeticAnchor value = anchor.value_or(GeodeticAnchor());
  info.flags = anchor ? info.flags | kHasAnchorFlag : info.flags & ~kHasAnchorFlag;
  info.anchor_latitude_deg = value.origin.latitude_deg;
  info.anchor_longitude_deg = value.origin.longitude_deg;
  info.anchor_height_m = value.origin.height_m;
  info.anchor_x_axis_east_rad = value.x_axis_east_rad;
}

std::optional<GeodeticAnchor> AnchorOf(const InfoRecord& info) {
  if ((info.flags & kHasAnchorFlag) == 0) return std::nullopt;
  return GeodeticAnchor{.origin = {.latitude_deg = info.anchor_latitude_deg,
                                   .longitude_deg = info.anchor_longitude_deg,
                                   .height_m = info.anchor_height_m},
                        .x_axis_east_rad = info.anchor_x_axis_east_rad};
}

}  // namespace dcloc
