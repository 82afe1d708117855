#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/files.h"
#include "server/net/listen_address.h"

namespace dcloc::server {

/// Sockets that listen on one port of every address of a host.
struct ListenSockets {
  std::vector<FileDescriptor> sockets;  ///< at least one; they do not block
  int port = 0;                         ///< the real one
};

/// Port 0 takes a free one. Unavailable names `setting`, the address's. A restarted server has its
/// port back at once (SO_REUSEADDR), and two cannot share one (no SO_REUSEPORT).
absl::StatusOr<ListenSockets> BindListenSockets(const ListenAddress& address,
                                                absl::string_view setting);

}  // namespace dcloc::server
