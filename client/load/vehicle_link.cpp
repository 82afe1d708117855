#include "client/load/vehicle_link.h"

#include <string>
#include <utility>

namespace dcloc::load {

absl::StatusOr<VehicleLink> MakeLink(client::ChannelOptions server, bool breaks) {
  server.own_connection = true;
  // Also where there is a relay: to where it leads, a token may not go in plaintext either.
  auto channel = client::MakeChannel(server);
  if (!channel.ok()) return channel.status();
  if (!breaks) return VehicleLink{.channel = *std::move(channel), .relay = nullptr};
  absl::StatusOr<std::unique_ptr<Relay>> relay = Relay::Start(server.server);
  if (!relay.ok()) return relay.status();
  if (!server.tls_ca.empty() && server.tls_server_name.empty()) {
    server.tls_server_name = server.server.substr(0, server.server.rfind(':'));
  }
  server.server = (*relay)->address();
  channel = client::MakeChannel(server);
  if (!channel.ok()) return channel.status();
  return VehicleLink{.channel = *std::move(channel), .relay = *std::move(relay)};
}

}  // namespace dcloc::load
