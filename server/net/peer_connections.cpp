#include "server/net/peer_connections.h"

#include <sys/stat.h>

#include <algorithm>

namespace dcloc::server {
namespace {

/// The socket that a descriptor has now; 0 if it has none.
ino_t SocketOf(int fd) {
  struct stat found {};
  return fstat(fd, &found) == 0 && S_ISSOCK(found.st_mode) ? found.st_ino : 0;
}

}  // namespace

bool PeerConnections::Add(const std::string& address, int socket_fd) {
  if (connections_.size() >= next_sweep_) ForgetClosed();
  std::vector<Connection>& of_address = connections_[address];
  if (of_address.size() >= max_count_) {
    std::erase_if(of_address, [](const Connection& connection) {
      return SocketOf(connection.fd) != connection.socket;
    });
  }
  if (of_address.size() >= max_count_) return false;
  of_address.push_back({.fd = socket_fd, .socket = SocketOf(socket_fd)});
  return true;
}

/// Addresses that are gone must not add up.
void PeerConnections::ForgetClosed() {
  for (auto& [address, of_address] : connections_) {
    std::erase_if(of_address, [](const Connection& connection) {
      return SocketOf(connection.fd) != connection.socket;
    });
  }
  std::erase_if(connections_, [](const auto& entry) { return entry.second.empty(); });
  next_sweep_ = 2 * connections_.size() + 64;
}

}  // namespace dcloc::server
