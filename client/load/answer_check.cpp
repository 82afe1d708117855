#include "client/load/answer_check.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/evaluation/metrics.h"
#include "client/evaluation/pose_error.h"

namespace dcloc::load {
namespace {

constexpr int kOutOfRange = 11;
constexpr int kCovarianceSize = 36;
constexpr double kQuaternionTolerance = 1e-6;

std::optional<std::string> PoseFault(const v1::PoseWithCovariance& pose) {
  const v1::Vector3& t = pose.pose().translation_m();
  const v1::Quaternion& q = pose.pose().rotation();
  const double norm = std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
  if (!std::isfinite(t.x()) || !std::isfinite(t.y()) || !std::isfinite(t.z())) {
    return "its position is not finite";
  }
  if (!(std::abs(norm - 1.0) < kQuaternionTolerance)) {
    return absl::StrFormat("its rotation has norm %g", norm);
  }
  if (pose.covariance_size() != kCovarianceSize) {
    return absl::StrCat("its covariance has ", pose.covariance_size(), " values");
  }
  const bool is_finite =
      std::ranges::all_of(pose.covariance(), [](double value) { return std::isfinite(value); });
  return is_finite ? std::nullopt : std::optional<std::string>("its covariance is not finite");
}

std::optional<std::string> ResultFault(const v1::LocalizationResult& result,
                                       const Expected& expected, std::int64_t map_version) {
  if (result.stamp_ns() != expected.scan->stamp_ns()) {
    return absl::StrCat("its stamp is ", result.stamp_ns(), ", the scan's ",
                        expected.scan->stamp_ns());
  }
  if (result.map_version() != map_version) {
    return absl::StrCat("its map version is ", result.map_version(), ", the session's ",
                        map_version);
  }
  return PoseFault(result.pose());
}

}  // namespace

std::optional<std::string> FaultOf(const v1::LocalizeResponse& answer, const Expected& expected,
                                   std::int64_t map_version) {
  const std::int64_t due = expected.scan->sequence_number();
  const std::int64_t number =
      answer.has_result() ? answer.result().sequence_number() : answer.rejected().sequence_number();
  if (number != due) return absl::StrCat("scan ", number, " was answered when ", due, " was due");
  const std::string prefix = absl::StrCat("the answer to scan ", due, ": ");
  if (answer.has_rejected()) {
    const bool is_late_refused = expected.sending == Sending::kReordered;
    if (answer.rejected().code() == kOutOfRange && !is_late_refused) {
      return absl::StrCat(prefix, "in order, and refused as late");
    }
    return std::nullopt;
  }
  if (expected.sending == Sending::kReordered) return absl::StrCat(prefix, "late, and not refused");
  if (expected.sending == Sending::kDuplicate && !answer.from_memory()) {
    return absl::StrCat(prefix, "localized a second time");
  }
  if (expected.sending == Sending::kOnce && !expected.resent && answer.from_memory()) {
    return absl::StrCat(prefix, "from memory, and it was sent once");
  }
  std::optional<std::string> fault = ResultFault(answer.result(), expected, map_version);
  if (fault) fault = absl::StrCat(prefix, *fault);
  return fault;
}

std::optional<PositionError> ErrorOf(const v1::LocalizationResult& result,
                                     const Eigen::Vector2d& true_position_m) {
  if (result.state() != v1::LOCALIZATION_STATE_TRACKING) return std::nullopt;
  const v1::Vector3& t = result.pose().pose().translation_m();
  const Eigen::Vector2d error = true_position_m - Eigen::Vector2d(t.x(), t.y());
  const auto& c = result.pose().covariance();
  Eigen::Matrix2d covariance;
  covariance << c.Get(0), c.Get(1), c.Get(6), c.Get(7);
  const bool outside = error.dot(covariance.inverse() * error) > ChiSquare999(2);
  return PositionError{.distance_m = error.norm(),
                       .misleading = error.norm() > kSuccessTranslation_m && outside};
}

}  // namespace dcloc::load
