#include "client/cli/doctor/clock_probe.h"

#include <optional>
#include <utility>

#include "client/cli/remote/wire.h"
#include "client/sdk/session.h"

namespace dcloc::cli {
namespace {

using Clock = std::chrono::system_clock;

double Seconds(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

Scan EmptyScan(const std::string& radar_id, Clock::time_point now) {
  Scan scan;
  scan.stamp = Stamp(std::chrono::duration_cast<std::chrono::nanoseconds>(now.time_since_epoch()));
  scan.radar_id = radar_id;
  return scan;
}

}  // namespace

absl::StatusOr<ClockOffset> CompareClocks(const std::shared_ptr<grpc::Channel>& channel,
                                          const std::string& map, const std::string& vehicle,
                                          const Rig& rig, std::chrono::milliseconds timeout) {
  v1::OpenSession open;
  open.set_vehicle_id(vehicle);
  open.set_map_name(map);
  *open.mutable_rig() = ToProto(rig);
  client::SessionOptions options;
  options.reconnect.reset();
  options.open_timeout = timeout;
  auto session = client::Session::Open(channel, std::move(open), options);
  if (!session.ok()) return session.status();
  const Clock::time_point sent = Clock::now();
  absl::Status status = (*session)->Send(ToProto(EmptyScan(rig.radars.front().id, sent), 0));
  if (!status.ok()) return status;
  (*session)->CloseSending();
  const std::optional<v1::LocalizeResponse> response = (*session)->Next();
  const std::chrono::nanoseconds round_trip = Clock::now() - sent;
  if (!response) {
    status = (*session)->EndStatus();
    return status.ok() ? absl::UnavailableError("the scan was not answered") : status;
  }
  if (!response->has_result()) return absl::InvalidArgumentError(response->rejected().message());
  const v1::StageTimings& timings = response->result().timings();
  const std::chrono::nanoseconds way =
      round_trip - std::chrono::nanoseconds(timings.total_duration_ns());
  const std::chrono::nanoseconds age(timings.stamp_age_ns());
  return ClockOffset{.offset_s = Seconds(age - way / 2), .bound_s = Seconds(way / 2)};
}

}  // namespace dcloc::cli
