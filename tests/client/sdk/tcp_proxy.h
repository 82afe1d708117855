#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace dcloc::client {

/// A TCP proxy on a free port of this machine that a test can cut: a network's way to fail.
class TcpProxy {
 public:
  /// Hands connections on to 127.0.0.1:`port`.
  explicit TcpProxy(int port);
  ~TcpProxy();
  TcpProxy(const TcpProxy&) = delete;
  TcpProxy& operator=(const TcpProxy&) = delete;

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  /// From now on connections are handed on to 127.0.0.1:`port`.
  void SetTarget(int port) { target_ = port; }

  /// Resets all connections that are there; new ones are taken. What was under way is lost.
  void Cut();

  /// How many connections were ever taken.
  int connection_count() const { return connection_count_; }

 private:
  void Accept();
  void Carry(int client);

  std::atomic<int> target_;
  int listener_ = -1;
  int port_ = 0;
  std::atomic<int> connection_count_ = 0;
  std::atomic<bool> stopping_ = false;
  std::mutex mutex_;
  std::vector<int> open_;  ///< sockets of the connections that are there
  std::vector<std::thread> carriers_;
  std::thread acceptor_;
};

}  // namespace dcloc::client
