#include "client/cli/remote/answer_text.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "absl/time/time.h"
#include "core/geometry/degrees.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

constexpr int kCovarianceSize = 36;

double Yaw_deg(const v1::Quaternion& q) {
  return std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()),
                    1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z())) *
         kDegPerRad;
}

/// Of the horizontal position, along the worse of the axes.
double Sigma_m(const v1::PoseWithCovariance& pose) {
  if (pose.covariance_size() != kCovarianceSize) return 0.0;
  return std::sqrt(std::max(pose.covariance(0), pose.covariance(7)));
}

double Milliseconds(std::int64_t duration_ns) { return 1e-6 * static_cast<double>(duration_ns); }

}  // namespace

std::string StateText(v1::LocalizationState state) {
  if (state == v1::LOCALIZATION_STATE_UNSPECIFIED) return "-";
  const std::string name = v1::LocalizationState_Name(state);
  return absl::AsciiStrToLower(absl::StripPrefix(name, "LOCALIZATION_STATE_"));
}

std::string TimeText(const google::protobuf::Timestamp& time) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::FromUnixSeconds(time.seconds()),
                          absl::UTCTimeZone());
}

std::string AgeText(double age_s) {
  if (age_s < 1.0) return absl::StrFormat("%.0f ms", 1e3 * age_s);
  if (age_s < 120.0) return absl::StrFormat("%.0f s", age_s);
  if (age_s < 7200.0) return absl::StrFormat("%.0f min", age_s / 60.0);
  return absl::StrFormat("%.0f h", age_s / 3600.0);
}

std::string AnswerLine(const v1::LocalizeResponse& answer) {
  if (answer.has_rejected()) {
    return absl::StrFormat("%8d  refused: %s", answer.rejected().sequence_number(),
                           answer.rejected().message());
  }
  const v1::LocalizationResult& result = answer.result();
  const v1::Vector3& t = result.pose().pose().translation_m();
  return absl::StrFormat("%8d  %-14s  x %10.2f  y %10.2f  yaw %7.2f deg  +- %.2f m  %.2f ms",
                         result.sequence_number(), StateText(result.state()), t.x(), t.y(),
                         Yaw_deg(result.pose().pose().rotation()), Sigma_m(result.pose()),
                         Milliseconds(result.timings().total_duration_ns()));
}

ordered_json AnswerJson(const v1::LocalizeResponse& answer) {
  if (answer.has_rejected()) {
    return {{"sequence_number", answer.rejected().sequence_number()},
            {"rejected", answer.rejected().message()},
            {"code", answer.rejected().code()}};
  }
  const v1::LocalizationResult& result = answer.result();
  const v1::Vector3& t = result.pose().pose().translation_m();
  const v1::Quaternion& q = result.pose().pose().rotation();
  return {{"sequence_number", result.sequence_number()},
          {"stamp_ns", result.stamp_ns()},
          {"state", StateText(result.state())},
          {"translation_m", {t.x(), t.y(), t.z()}},
          {"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
          {"sigma_m", Sigma_m(result.pose())},
          {"overlap", result.quality().overlap()},
          {"edge_distance", result.quality().edge_distance()},
          {"edge_valid", result.quality().edge_valid()},
          {"beta_error_s", result.quality().beta_error_s()},
          {"beta_error_sigma_s", result.quality().beta_error_sigma_s()},
          {"beta_is_wrong", result.quality().beta_is_wrong()},
          {"map_version", result.map_version()},
          {"total_ms", Milliseconds(result.timings().total_duration_ns())}};
}

ordered_json SessionJson(const v1::Session& session) {
  ordered_json json = {{"session_id", session.session_id()},
                       {"vehicle_id", session.vehicle_id()},
                       {"peer", session.peer()},
                       {"map", session.map_name()},
                       {"map_version", session.map_version()},
                       {"open_time", TimeText(session.open_time())},
                       {"state", StateText(session.state())},
                       {"detached", session.detached()},
                       {"scan_count", session.scan_count()},
                       {"rejected_scan_count", session.rejected_scan_count()},
                       {"repeated_scan_count", session.repeated_scan_count()},
                       {"dropped_scan_count", session.dropped_scan_count()},
                       {"missing_scan_count", session.missing_scan_count()},
                       {"resume_count", session.resume_count()},
                       {"last_sequence_number", nullptr},
                       {"last_stamp_age_s", 1e-3 * Milliseconds(session.last_stamp_age_ns())},
                       {"idle_s", 1e-3 * Milliseconds(session.idle_duration_ns())}};
  if (session.has_last_sequence_number()) {
    json["last_sequence_number"] = session.last_sequence_number();
  }
  return json;
}

}  // namespace dcloc::cli
