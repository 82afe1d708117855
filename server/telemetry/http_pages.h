#pragma once

#include <chrono>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/net/listen_address.h"
#include "server/net/listen_sockets.h"

namespace dcloc::server {

struct HttpAnswer {
  const char* status = "200 OK";
  std::string body;
};

/// What GET gives at a path.
struct HttpPage {
  std::string path;
  std::function<HttpAnswer()> make;
  bool is_urgent = false;  ///< takes no time, and must not wait for pages that do
};

/// Serves a few pages by HTTP, plaintext text, on one thread that waits for no peer: one that sends
/// or reads slowly has a second for each. Connections are bounded; a new one ends the oldest.
class HttpPages {
 public:
  /// Port 0 takes a free one. Unavailable, naming `setting`, when the address cannot be listened
  /// on.
  static absl::StatusOr<std::unique_ptr<HttpPages>> Serve(const ListenAddress& address,
                                                          absl::string_view setting,
                                                          std::vector<HttpPage> pages);
  ~HttpPages();
  HttpPages(const HttpPages&) = delete;
  HttpPages& operator=(const HttpPages&) = delete;

  /// HOST:PORT with the real port.
  const std::string& address() const { return address_; }

 private:
  using Clock = std::chrono::steady_clock;

  enum class State { kReading, kAsking, kWriting, kDone };

  struct Connection {
    FileDescriptor socket;
    State state = State::kReading;
    Clock::time_point deadline;
    std::string request;
    std::string response;
    std::size_t sent_bytes = 0;
  };

  HttpPages(ListenSockets listening, FileDescriptor wake, std::string address,
            std::vector<HttpPage> pages);
  void Run();
  void AnswerAll();
  bool WaitForPeers();
  void Accept(int listening_fd);
  void Move(Connection& connection, short events);
  void Read(Connection& connection);
  void Write(Connection& connection);
  void Answer();
  void Answer(Connection& connection, HttpAnswer answer);
  const HttpPage* PageOf(const Connection& connection) const;

  const ListenSockets listening_;
  const FileDescriptor wake_;  ///< readable once it is to stop
  const std::string address_;
  const std::vector<HttpPage> pages_;
  std::list<Connection> connections_;  ///< the oldest first
  std::thread thread_;                 ///< last: it uses the others
};

}  // namespace dcloc::server
