#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "core/radar/radar_model.h"

namespace dcloc::cli {

/// The server's clock beside this machine's.
struct ClockOffset {
  double offset_s = 0.0;  ///< server minus this machine
  double bound_s = 0.0;   ///< it is known to so much: half of the way there and back
};

/// Opens a session in `map` as `vehicle`, sends one scan without targets that is stamped now, and
/// ends the session. Errors as of client::Session.
absl::StatusOr<ClockOffset> CompareClocks(const std::shared_ptr<grpc::Channel>& channel,
                                          const std::string& map, const std::string& vehicle,
                                          const Rig& rig, std::chrono::milliseconds timeout);

}  // namespace dcloc::cli
