#pragma once

#include <netdb.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"

namespace dcloc::load {

/// A TCP relay to a server through a port of this machine, whose connections can be reset to
/// imitate a failing network. It does not inspect the bytes, so TLS works through it. Thread-safe.
class Relay {
 public:
  /// To `server`, HOST:PORT. Errors name it, or say why there is no port.
  static absl::StatusOr<std::unique_ptr<Relay>> Start(const std::string& server);
  ~Relay();
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// Where it listens.
  std::string address() const;

  /// Resets the present connections on both sides; bytes in transit are lost. New connections are
  /// accepted.
  void Cut();

 private:
  using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;
  struct Link {
    int client;
    int server;
  };

  Relay(Addresses server, int listener, int port, int wake);

  void Run();
  void Accept();
  void Carry(std::size_t index, short client_events, short server_events);
  int Connect() const;

  const Addresses server_;
  const int listener_;
  const int port_;
  const int wake_;  ///< readable when the thread shall end
  std::atomic<bool> stopping_ = false;
  std::mutex mutex_;
  std::vector<Link> links_;  ///< changed by the thread alone
  std::thread thread_;       ///< last: it uses the others
};

}  // namespace dcloc::load
