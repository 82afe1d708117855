#pragma once

#include <sys/types.h>

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace dcloc::server {

/// Counts the open connections of each address. gRPC does not tell when it closes one, but its
/// descriptor then has another socket or none. Not thread-safe.
class PeerConnections {
 public:
  /// `max_count` > 0: connections of one address.
  explicit PeerConnections(int max_count) : max_count_(static_cast<std::size_t>(max_count)) {}

  /// Counts a connection; false, and it is not counted, if its address has as many as it may.
  bool Add(const std::string& address, int socket_fd);

 private:
  struct Connection {
    int fd = -1;
    ino_t socket = 0;
  };

  void ForgetClosed();

  const std::size_t max_count_;
  std::size_t next_sweep_ = 64;  ///< with so many addresses
  std::map<std::string, std::vector<Connection>> connections_;
};

}  // namespace dcloc::server
