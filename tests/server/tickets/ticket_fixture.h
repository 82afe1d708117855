#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/tickets/session_tickets.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {

inline constexpr SystemTime kTicketNow{std::chrono::seconds(1'800'000'000)};

inline std::string KeyLine(const std::string& id, char digit) {
  return absl::StrCat(id, " ", std::string(64, digit), "\n");
}

/// A file of keys, as an operator has it.
struct KeyFile {
  explicit KeyFile(const std::string& lines) { Write(lines); }

  void Write(const std::string& lines) {
    path = folder.Write("keys", std::as_bytes(std::span(lines)));
    std::filesystem::permissions(path, std::filesystem::perms(0600));
  }

  /// What one server of the fleet has.
  std::unique_ptr<SessionTickets> Tickets() const {
    auto keys = ServedTicketKeys::Load(path);
    if (!keys.ok()) throw std::runtime_error(std::string(keys.status().message()));
    return std::make_unique<SessionTickets>(*std::move(keys), std::chrono::seconds(60),
                                            std::chrono::seconds(1));
  }

  TemporaryFolder folder;
  std::filesystem::path path;
};

/// Of a vehicle that has been tracked for long.
inline TicketContent SomeContent() {
  LocalizerSnapshot snapshot;
  snapshot.stamp = Stamp(std::chrono::seconds(1'700'000'000));
  snapshot.pose.T_map_vehicle.translation_m = {1234.5, -678.9, 0.1};
  snapshot.pose.covariance = 0.01 * Matrix6d::Identity();
  snapshot.pose.covariance(0, 5) = snapshot.pose.covariance(5, 0) = 0.001;
  snapshot.velocity.linear_mps = {13.0, 0.1, 0.0};
  snapshot.velocity.covariance = 0.02 * Matrix6d::Identity();
  snapshot.tracking.mode = TrackingMode::kConfirmed;
  snapshot.tracking.observability = AlongTrackObservability::kFading;
  snapshot.tracking.last_accepted = snapshot.stamp - std::chrono::milliseconds(77);
  snapshot.tracking.last_lost_to_outliers = snapshot.stamp - std::chrono::hours(1);
  snapshot.tracking.usual_interval_s = 0.15;
  snapshot.known.wheel_scale = {1.01, 1e-5};
  snapshot.known.Of("front").mount_yaw_error = {0.01, 1e-6};
  snapshot.noise.translation.far.error = -0.5;
  snapshot.noise.rotation.registration_ratio = 3.0;
  snapshot.resets.count = 2;
  snapshot.resets.T_before_after.translation_m.x() = 0.7;
  snapshot.mean_nis = 1.5;
  snapshot.contradiction_m = 0.25;
  snapshot.registration_count = 99;
  snapshot.clocks_ahead = {std::chrono::seconds(5)};
  return {.map_version = 7,
          .map_sha256 = std::string(64, 'a'),
          .epoch = 3,
          .last_sequence_number = 4711,
          .session_id = "0123456789abcdef0123456789abcdef",
          .snapshot = snapshot};
}

/// A vehicle's `open` in a map.
inline v1::OpenSession SomeOpen() {
  v1::OpenSession open;
  open.set_vehicle_id("car-1");
  open.set_map_name("town");
  open.mutable_rig()->add_radars()->set_radar_id("front");
  return open;
}

inline TicketBinding SomeBinding() {
  return BindingOf({.name = "fleet-a", .tenant = "north"}, SomeOpen());
}

}  // namespace dcloc::server
