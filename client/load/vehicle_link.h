#pragma once

#include <grpcpp/channel.h>

#include <memory>

#include "absl/status/statusor.h"
#include "client/load/relay.h"
#include "client/sdk/channel.h"

namespace dcloc::load {

/// A vehicle's own connection to the server.
struct VehicleLink {
  std::shared_ptr<grpc::Channel> channel;
  /// What the channel goes through when it is to break; without it only streams can be ended.
  std::shared_ptr<Relay> relay;
};

/// With a relay where it `breaks`. Errors of `client::MakeChannel` and `Relay::Start`.
absl::StatusOr<VehicleLink> MakeLink(client::ChannelOptions server, bool breaks);

}  // namespace dcloc::load
