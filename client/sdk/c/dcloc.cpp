#include "client/sdk/c/dcloc.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <initializer_list>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/sdk/channel.h"
#include "client/sdk/session.h"

struct dcloc_config {
  dcloc::client::ChannelOptions channel;
  dcloc::client::SessionOptions session;
  dcloc::v1::OpenSession open;
};

struct dcloc_session {
  std::unique_ptr<dcloc::client::Session> session;
};

namespace {

namespace client = dcloc::client;
namespace v1 = dcloc::v1;

thread_local std::string last_error;  // NOLINT: an accessor of the last error needs it

dcloc_status Fail(dcloc_status status, const char* text) noexcept {
  try {
    last_error = text;
  } catch (...) {
    last_error.clear();  // no memory for it
  }
  return status;
}

/// The edge of the library: statuses become numbers with a text, exceptions too.
template <typename Call>
dcloc_status Guard(const Call& call) noexcept {
  try {
    const absl::Status status = call();
    if (!status.ok()) last_error = std::string(status.message());
    return static_cast<dcloc_status>(status.code());
  } catch (const std::bad_alloc&) {
    return Fail(DCLOC_RESOURCE_EXHAUSTED, "no memory");
  } catch (const std::exception& error) {
    return Fail(DCLOC_INTERNAL, error.what());
  } catch (...) {
    return Fail(DCLOC_INTERNAL, "unknown exception");
  }
}

/// OK where no pointer is null; the names are in the order of the pointers.
absl::Status CheckPointers(std::initializer_list<std::pair<const char*, const void*>> pointers) {
  for (const auto& [name, pointer] : pointers) {
    if (pointer == nullptr) return absl::InvalidArgumentError(absl::StrCat(name, " is NULL"));
  }
  return absl::OkStatus();
}

/// Whether the caller's struct has all that version 1 has.
template <typename Struct>
absl::Status CheckSize(const char* name, const Struct& value) {
  if (value.struct_size >= sizeof(Struct)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(name, ".struct_size is ", value.struct_size,
                                                 "; it must be sizeof(", name, "), ",
                                                 sizeof(Struct)));
}

void SetPose(const double* translation_m, const double* rotation_wxyz, v1::Pose& pose) {
  pose.mutable_translation_m()->set_x(translation_m[0]);
  pose.mutable_translation_m()->set_y(translation_m[1]);
  pose.mutable_translation_m()->set_z(translation_m[2]);
  pose.mutable_rotation()->set_w(rotation_wxyz[0]);
  pose.mutable_rotation()->set_x(rotation_wxyz[1]);
  pose.mutable_rotation()->set_y(rotation_wxyz[2]);
  pose.mutable_rotation()->set_z(rotation_wxyz[3]);
}

v1::EgoVelocity VelocityFrom(const double* velocity) {
  v1::EgoVelocity message;
  message.mutable_linear_mps()->set_x(velocity[0]);
  message.mutable_linear_mps()->set_y(velocity[1]);
  message.mutable_linear_mps()->set_z(velocity[2]);
  message.mutable_angular_radps()->set_x(velocity[3]);
  message.mutable_angular_radps()->set_y(velocity[4]);
  message.mutable_angular_radps()->set_z(velocity[5]);
  return message;
}

v1::Scan ScanFrom(const dcloc_scan& scan) {
  v1::Scan message;
  message.set_sequence_number(scan.sequence_number);
  message.set_stamp_ns(scan.stamp_ns);
  message.set_radar_id(scan.radar_id);
  const auto add = [&](const float* column, auto* field) {
    if (column != nullptr) field->Add(column, column + scan.target_count);
  };
  add(scan.range_m, message.mutable_range_m());
  add(scan.range_rate_mps, message.mutable_range_rate_mps());
  add(scan.azimuth_rad, message.mutable_azimuth_rad());
  add(scan.elevation_rad, message.mutable_elevation_rad());
  add(scan.rcs_dbsm, message.mutable_rcs_dbsm());
  if (scan.ego_velocity != nullptr)
    *message.mutable_ego_velocity() = VelocityFrom(scan.ego_velocity);
  return message;
}

/// All but the size, which is the caller's.
void Write(const client::PoseEstimate& estimate, dcloc_pose& pose) {
  pose.stamp_ns = estimate.stamp_ns;
  pose.answer_stamp_ns = estimate.answer_stamp_ns;
  std::ranges::copy(estimate.T_map_vehicle.translation_m, pose.translation_m);
  std::ranges::copy(estimate.T_map_vehicle.rotation_wxyz, pose.rotation_wxyz);
  std::ranges::copy(estimate.covariance, pose.covariance);
  std::ranges::copy(estimate.velocity, pose.velocity);
  pose.state = static_cast<std::int32_t>(estimate.state);
}

void Write(const v1::LocalizationResult& result, dcloc_answer& answer) {
  answer.sequence_number = result.sequence_number();
  answer.rejection = DCLOC_OK;
  answer.protection_level_m = result.has_protection_level_m() ? result.protection_level_m() : -1.0;
  dcloc_pose& pose = answer.pose;
  pose.stamp_ns = pose.answer_stamp_ns = result.stamp_ns();
  const v1::Vector3& t = result.pose().pose().translation_m();
  const v1::Quaternion& q = result.pose().pose().rotation();
  const double translation_m[] = {t.x(), t.y(), t.z()};
  const double rotation_wxyz[] = {q.w(), q.x(), q.y(), q.z()};
  std::ranges::copy(translation_m, pose.translation_m);
  std::ranges::copy(rotation_wxyz, pose.rotation_wxyz);
  std::ranges::fill(pose.covariance, 0.0);
  std::copy_n(result.pose().covariance().begin(), std::min(36, result.pose().covariance_size()),
              pose.covariance);
  std::ranges::fill(pose.velocity, 0.0);
  pose.state = static_cast<std::int32_t>(result.state());
}

using Asked = absl::StatusOr<client::PoseEstimate> (client::Session::*)(std::int64_t) const;

dcloc_status Ask(const dcloc_session* session, std::int64_t stamp_ns, dcloc_pose* pose,
                 Asked asked) noexcept {
  return Guard([&] {
    absl::Status status = CheckPointers({{"session", session}, {"pose", pose}});
    if (status.ok()) status = CheckSize("dcloc_pose", *pose);
    if (!status.ok()) return status;
    const absl::StatusOr<client::PoseEstimate> estimate = ((*session->session).*asked)(stamp_ns);
    if (estimate.ok()) Write(*estimate, *pose);
    return estimate.status();
  });
}

}  // namespace

extern "C" {

const char* dcloc_version() { return DCLOC_VERSION; }
const char* dcloc_error_text() { return last_error.c_str(); }

dcloc_config* dcloc_config_new(const char* server, const char* map, const char* vehicle) {
  dcloc_config* config = nullptr;
  Guard([&] {
    auto made = std::make_unique<dcloc_config>();
    made->channel.server = server == nullptr ? "" : server;
    made->open.set_map_name(map == nullptr ? "" : map);
    made->open.set_vehicle_id(vehicle == nullptr ? "" : vehicle);
    config = made.release();
    return absl::OkStatus();
  });
  return config;
}

void dcloc_config_free(dcloc_config* config) { delete config; }

dcloc_status dcloc_config_set_tls(dcloc_config* config, const char* ca_file, const char* cert_file,
                                  const char* key_file) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"config", config}, {"ca_file", ca_file}});
    if (!status.ok()) return status;
    config->channel.tls_ca = ca_file;
    config->channel.tls_cert = cert_file == nullptr ? "" : cert_file;
    config->channel.tls_key = key_file == nullptr ? "" : key_file;
    return status;
  });
}

dcloc_status dcloc_config_set_token_file(dcloc_config* config, const char* file) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"config", config}, {"file", file}});
    if (status.ok()) config->channel.token_file = file;
    return status;
  });
}

dcloc_status dcloc_config_add_radar(dcloc_config* config, const char* radar_id,
                                    const double translation_m[3], const double rotation_wxyz[4],
                                    double beta_s) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"config", config},
                                         {"radar_id", radar_id},
                                         {"translation_m", translation_m},
                                         {"rotation_wxyz", rotation_wxyz}});
    if (!status.ok()) return status;
    v1::RadarModel& radar = *config->open.mutable_rig()->add_radars();
    radar.set_radar_id(radar_id);
    SetPose(translation_m, rotation_wxyz, *radar.mutable_t_vehicle_radar());
    radar.set_beta_s(beta_s);
    return status;
  });
}

dcloc_status dcloc_config_set_initial_pose(dcloc_config* config, const double translation_m[3],
                                           const double rotation_wxyz[4],
                                           const double covariance[36]) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"config", config},
                                         {"translation_m", translation_m},
                                         {"rotation_wxyz", rotation_wxyz},
                                         {"covariance", covariance}});
    if (!status.ok()) return status;
    v1::PoseWithCovariance& pose = *config->open.mutable_initial_pose();
    SetPose(translation_m, rotation_wxyz, *pose.mutable_pose());
    pose.clear_covariance();
    pose.mutable_covariance()->Add(covariance, covariance + 36);
    return status;
  });
}

dcloc_status dcloc_config_set_reconnect_ms(dcloc_config* config, int64_t give_up_after_ms) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"config", config}});
    if (!status.ok()) return status;
    config->session.reconnect.reset();
    if (give_up_after_ms != 0) {
      config->session.reconnect =
          client::ReconnectOptions{.give_up_after = std::chrono::milliseconds(give_up_after_ms)};
    }
    return status;
  });
}

dcloc_status dcloc_config_forget_answers(dcloc_config* config) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"config", config}});
    if (status.ok()) config->session.unread_answers = client::UnreadAnswers::kForgetOldest;
    return status;
  });
}

dcloc_status dcloc_session_open(const dcloc_config* config, dcloc_session** session) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"config", config}, {"session", session}});
    if (!status.ok()) return status;
    *session = nullptr;
    const auto channel = client::MakeChannel(config->channel);
    if (!channel.ok()) return channel.status();
    auto opened = client::Session::Open(*channel, config->open, config->session);
    if (!opened.ok()) return opened.status();
    *session = new dcloc_session{*std::move(opened)};
    return status;
  });
}

void dcloc_session_free(dcloc_session* session) { delete session; }

dcloc_status dcloc_session_send_scan(dcloc_session* session, const dcloc_scan* scan) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"session", session}, {"scan", scan}});
    if (status.ok()) status = CheckSize("dcloc_scan", *scan);
    if (status.ok()) status = CheckPointers({{"scan.radar_id", scan->radar_id}});
    return status.ok() ? session->session->Send(ScanFrom(*scan)) : status;
  });
}

dcloc_status dcloc_session_add_motion(dcloc_session* session, int64_t stamp_ns, double speed_mps,
                                      double yaw_rate_radps) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"session", session}});
    if (!status.ok()) return status;
    client::MotionTick tick{.stamp_ns = stamp_ns};
    if (!std::isnan(speed_mps)) tick.speed_mps = speed_mps;
    if (!std::isnan(yaw_rate_radps)) tick.yaw_rate_radps = yaw_rate_radps;
    return session->session->AddMotion(tick);
  });
}

dcloc_status dcloc_session_add_ego_velocity(dcloc_session* session, int64_t stamp_ns,
                                            const double velocity[6]) {
  return Guard([&] {
    const absl::Status status = CheckPointers({{"session", session}, {"velocity", velocity}});
    return status.ok() ? session->session->AddEgoVelocity(stamp_ns, VelocityFrom(velocity))
                       : status;
  });
}

dcloc_status dcloc_session_pose_at(const dcloc_session* session, int64_t stamp_ns,
                                   dcloc_pose* pose) {
  return Ask(session, stamp_ns, pose, &client::Session::PoseAt);
}

dcloc_status dcloc_session_smooth_pose_at(const dcloc_session* session, int64_t stamp_ns,
                                          dcloc_pose* pose) {
  return Ask(session, stamp_ns, pose, &client::Session::SmoothPoseAt);
}

dcloc_status dcloc_session_next(dcloc_session* session, dcloc_answer* answer) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"session", session}, {"answer", answer}});
    if (status.ok()) status = CheckSize("dcloc_answer", *answer);
    if (!status.ok()) return status;
    const std::optional<v1::LocalizeResponse> next = session->session->Next();
    if (!next) return absl::OutOfRangeError("the session has ended and all answers are taken");
    if (next->has_result()) {
      Write(next->result(), *answer);
    } else {
      answer->sequence_number = next->rejected().sequence_number();
      answer->rejection = next->rejected().code();
      answer->protection_level_m = -1.0;
      last_error = next->rejected().message();
    }
    return status;
  });
}

dcloc_status dcloc_session_close_sending(dcloc_session* session) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"session", session}});
    if (status.ok()) session->session->CloseSending();
    return status;
  });
}

dcloc_status dcloc_session_cancel(dcloc_session* session) {
  return Guard([&] {
    absl::Status status = CheckPointers({{"session", session}});
    if (status.ok()) session->session->Cancel();
    return status;
  });
}

dcloc_status dcloc_session_end_status(const dcloc_session* session) {
  return Guard([&] {
    const absl::Status status = CheckPointers({{"session", session}});
    return status.ok() ? session->session->EndStatus() : status;
  });
}

}  // extern "C"
