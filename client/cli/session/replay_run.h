#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/sdk/channel.h"

namespace dcloc::cli {

/// What `dcloc session replay` was asked for, as it was written.
struct ReplayArguments {
  std::string file;
  std::string map_file;           ///< or a server
  client::ChannelOptions server;  ///< `server.server` may be empty
  bool any_map = false;
  bool json = false;
};

/// Localizes the recorded scans again and prints how the answers compare. An error when one
/// differs, or the recording or the map cannot be used.
absl::Status RunReplay(const ReplayArguments& arguments);

}  // namespace dcloc::cli
