#include "client/cli/remote/answer_text.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

std::string LowerName(const std::string& name, absl::string_view prefix) {
  return absl::AsciiStrToLower(absl::StripPrefix(name, prefix));
}

std::string StampText(std::int64_t stamp_ns) {
  constexpr std::int64_t kPerSecond = 1'000'000'000;
  return absl::StrFormat("%d.%09d", stamp_ns / kPerSecond, stamp_ns % kPerSecond);
}

/// Of a SourceHealth or a RadarHealth.
template <typename Message>
void AppendSetAside(const std::string& name, const Message& health, std::string* text) {
  if (health.used() || health.fault() <= v1::SOURCE_FAULT_SILENT) return;
  absl::StrAppend(text, text->empty() ? "" : ", ", name, " (", FaultText(health.fault()), ")");
}

template <typename Message>
ordered_json SourceJson(const Message& health) {
  return {{"used", health.used()}, {"fault", FaultText(health.fault())}};
}

std::string FixLine(const v1::PositionFixAnswer& answer) {
  return absl::StrCat("     fix  of ", StampText(answer.stamp_ns()), ": ", UseText(answer.use()),
                      answer.message().empty() ? "" : ", ", answer.message());
}

}  // namespace

std::string StateText(v1::LocalizationState state) {
  if (state == v1::LOCALIZATION_STATE_UNSPECIFIED) return "-";
  return LowerName(v1::LocalizationState_Name(state), "LOCALIZATION_STATE_");
}

std::string FaultText(v1::SourceFault fault) {
  return LowerName(v1::SourceFault_Name(fault), "SOURCE_FAULT_");
}

std::string UseText(v1::FixUse use) { return LowerName(v1::FixUse_Name(use), "FIX_USE_"); }

std::string SetAsideText(const v1::Health& health) {
  std::string text;
  AppendSetAside("wheel speed", health.wheel_speed(), &text);
  AppendSetAside("yaw rate", health.yaw_rate(), &text);
  for (const v1::RadarHealth& radar : health.radars()) {
    AppendSetAside(absl::StrCat("radar ", radar.radar_id()), radar, &text);
  }
  return text;
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
  if (answer.has_position_fix_answer()) return FixLine(answer.position_fix_answer());
  if (answer.has_rejected()) {
    return absl::StrFormat("%8d  refused: %s", answer.rejected().sequence_number(),
                           answer.rejected().message());
  }
  const v1::LocalizationResult& result = answer.result();
  const v1::Vector3& t = result.pose().pose().translation_m();
  std::string line =
      absl::StrFormat("%8d  %-14s  x %10.2f  y %10.2f  yaw %7.2f deg  +- %.2f m",
                      result.sequence_number(), StateText(result.state()), t.x(), t.y(),
                      Yaw_deg(result.pose().pose().rotation()), Sigma_m(result.pose()));
  if (result.has_protection_level_m()) {
    absl::StrAppendFormat(&line, " (<= %.2f m)", result.protection_level_m());
  }
  absl::StrAppendFormat(&line, "  %.2f ms", Milliseconds(result.timings().total_duration_ns()));
  if (const int resets = static_cast<int>(result.resets().count()); resets > 0) {
    absl::StrAppendFormat(&line, "  %d resets", resets);
  }
  if (const std::string set_aside = SetAsideText(result.health()); !set_aside.empty()) {
    absl::StrAppend(&line, "  without ", set_aside);
  }
  return line;
}

ordered_json HealthJson(const v1::Health& health) {
  ordered_json radars = ordered_json::object();
  for (const v1::RadarHealth& radar : health.radars()) radars[radar.radar_id()] = SourceJson(radar);
  return {{"wheel_speed", SourceJson(health.wheel_speed())},
          {"yaw_rate", SourceJson(health.yaw_rate())},
          {"radars", std::move(radars)}};
}

ordered_json AnswerJson(const v1::LocalizeResponse& answer) {
  if (answer.has_position_fix_answer()) {
    const v1::PositionFixAnswer& fix = answer.position_fix_answer();
    return {
        {"fix_stamp_ns", fix.stamp_ns()}, {"use", UseText(fix.use())}, {"message", fix.message()}};
  }
  if (answer.has_rejected()) {
    return {{"sequence_number", answer.rejected().sequence_number()},
            {"rejected", answer.rejected().message()},
            {"code", answer.rejected().code()}};
  }
  const v1::LocalizationResult& result = answer.result();
  const v1::Vector3& t = result.pose().pose().translation_m();
  const v1::Quaternion& q = result.pose().pose().rotation();
  ordered_json json = {{"sequence_number", result.sequence_number()},
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
                       {"total_ms", Milliseconds(result.timings().total_duration_ns())},
                       {"protection_level_m", nullptr},
                       {"reset_count", result.resets().count()},
                       {"health", HealthJson(result.health())}};
  if (result.has_protection_level_m()) json["protection_level_m"] = result.protection_level_m();
  return json;
}

ordered_json SessionJson(const v1::Session& session) {
  ordered_json json = {{"session_id", session.session_id()},
                       {"vehicle_id", session.vehicle_id()},
                       {"peer", session.peer()},
                       {"replica", session.replica()},
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
                       {"position_fix_count", session.position_fix_count()},
                       {"pose_reset_count", session.pose_reset_count()},
                       {"set_aside", SetAsideText(session.health())},
                       {"health", HealthJson(session.health())},
                       {"last_sequence_number", nullptr},
                       {"last_stamp_age_s", 1e-3 * Milliseconds(session.last_stamp_age_ns())},
                       {"idle_s", 1e-3 * Milliseconds(session.idle_duration_ns())}};
  if (session.has_last_sequence_number()) {
    json["last_sequence_number"] = session.last_sequence_number();
  }
  return json;
}

}  // namespace dcloc::cli
